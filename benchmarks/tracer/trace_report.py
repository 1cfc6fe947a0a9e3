"""The study's records as tables that people read."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.tables import share, table
from benchmarks.tracer.judge import GOOD, VERDICTS
from benchmarks.tracer.trace_cases import GROUPS
from simulator.trial_command import EXCITATIONS

Record = dict[str, Any]
NOISE = {
    "commanded": "a torque that is the command as it was given, 10, 20 or 40 times a second, in two of five recordings "
    "rounded to 1 to 2.5 % of the full torque; all noise of the residual in the water",
    "measured": "a torque that is measured, with white noise, 1 % outliers and often coarse steps; what lasts of the "
    "residual's noise in the water",
    "torque": "a torque that is measured, with all noise of the residual in its sensor, also what lasts, as in "
    "textbooks and on no vehicle; 1 % outliers and often coarse steps",
}
"""What the torque is, and where the noise is (simulator/trial_sensors.py)."""
INVISIBLE = 20.0
"""Expected evidence below which the hidden effect is not in the data, for a reader who knows its shape and parameters.

Twice a log-likelihood ratio. Such trials are counted like all others; the last column says how many there are.
"""


def report(document: dict[str, Any]) -> str:
    """Markdown."""
    records: list[Record] = document["records"]
    parts = [
        "# What the tracer names when something is hidden",
        f"Made by `{document['command']}` on {document['date']}, seeds from {document['first_seed']}, "
        f"{len(records)} of {document['planned']} planned recordings of {records[0]['duration'] / 60:.0f} minutes "
        f"with a gyro at about 20 Hz, traced in {document['minutes']} minutes.",
        "The vehicles come from `simulator/trial.py`, which shares nothing with the tracer: drag that is no "
        f"polynomial; {NOISE[records[0]['noise']]}; a noisy gyro, which the controller in closed loop sees, too; in "
        "half of the recordings streams on their own clocks; idle channels. Noise: 3.5 % of the full torque (3.5 N m "
        "at the paper's scale), residual autocorrelation over 0.05 s as given, in trials with effects 0, 0.5 or 0.9.",
        _summary(records),
        "\n".join(f"- {name}: {meaning}." for name, meaning in VERDICTS.items()),
        f"Invisible: trials whose evidence is below {INVISIBLE:g} for a reader who knows the effect's shape and "
        "parameters and the noise; they count like the others.",
        "## False alarms with nothing hidden",
        _alarms(records),
    ]
    for group in ("one", "half"):
        chosen = [record for record in records if record["group"] == group]
        if chosen:
            parts += [f"## {GROUPS[group].capitalize()}", _confusion(chosen)]
    parts += ["## After-error, parameters and time", _quality(records)]
    if any("peers" in record for record in records):
        parts += ["## Peers on the same recordings", _peers(records)]
    parts += ["## Every miss", _misses(records)]
    return "\n\n".join(part for part in parts if part) + "\n"


def _summary(records: Sequence[Record]) -> str:
    rows = []
    for group, meaning in GROUPS.items():
        chosen = [record for record in records if record["group"] == group]
        if not chosen:
            continue
        counts = Counter(record["judged"] for record in chosen)
        good = sum(counts[verdict] for verdict in GOOD)
        invisible = sum(record["evidence"] < INVISIBLE for record in chosen) if group != "quiet" else "–"
        cells = [counts[verdict] for verdict in (*VERDICTS, "failed")]
        shares = share(good, len(chosen)), share(good + counts["joint"], len(chosen))
        rows.append([meaning, len(chosen), *cells, *shares, invisible])
    head = ["hidden", "runs", *VERDICTS, "failed", "right or class (95 %)", "or joint (95 %)", "invisible"]
    return table(head, rows)


def _alarms(records: Sequence[Record]) -> str:
    quiet = [record for record in records if record["group"] == "quiet"]
    rows = []
    for level in sorted({record["autocorrelation"] for record in quiet}):
        chosen = [record for record in quiet if record["autocorrelation"] == level]
        alarms = [name for record in chosen for name in record["named"]]
        false = sum(bool(record["named"]) for record in chosen)
        unexplained = sum(record["verdict"] == "unexplained" for record in chosen)
        named = ", ".join(f"{name} {count}" for name, count in Counter(alarms).most_common())
        failed = sum(bool(record["failure"]) for record in chosen)
        rows.append([level, len(chosen), failed, false, share(false, len(chosen) - failed), unexplained, named or "–"])
    head = [
        "residual autocorrelation",
        "runs",
        "failed",
        "with a false effect",
        "share (95 %)",
        "“unexplained”",
        "named",
    ]
    return table(head, rows)


def _confusion(records: Sequence[Record]) -> str:
    kinds = dict.fromkeys(_kind(record) for record in records)
    rows = []
    for kind in kinds:
        mine = [record for record in records if _kind(record) == kind]
        cells = [_cell([record for record in mine if record["excitation"] == each]) for each in EXCITATIONS]
        wrong = Counter(name for record in mine for name in record["named"] if name not in record["effects"])
        named = ", ".join(f"{name} {count}" for name, count in wrong.most_common(4))
        rows.append([kind, *cells, _cell(mine), named or "–"])
    text = "Each cell: right + class / runs; then j joint, m missed, f false beside, b both, x failed."
    return f"{text}\n\n{table(['hidden', *EXCITATIONS, 'all', 'named instead or beside'], rows)}"


def _cell(records: Sequence[Record]) -> str:
    if not records:
        return "–"
    counts = Counter(record["judged"] for record in records)
    marks = {"joint": "j", "missed": "m", "false": "f", "both": "b", "failed": "x"}
    rest = "".join(f" {counts[verdict]}{mark}" for verdict, mark in marks.items() if counts[verdict])
    return f"{counts['right']}+{counts['class']}/{len(records)}{rest}"


def _kind(record: Record) -> str:
    return str(record["effects"][0]).partition(":")[0]


def _quality(records: Sequence[Record]) -> str:
    rows = []
    for group, meaning in GROUPS.items():
        chosen = [record for record in records if record["group"] == group and not record["failure"]]
        if not chosen:
            continue
        twins = np.array([_ratio(_error(record, "after"), record.get("twin", {})) for record in chosen])
        floors = np.array([_ratio(_error(record, "after"), _error(record, "floor")) for record in chosen])
        free = np.array(
            [_ratio(_error(record, "after"), _error(record, "before"), "free_run_rmse") for record in chosen]
        )
        seconds = np.array([record["seconds"] for record in chosen])
        within = share(int(np.sum(twins <= 1.05)), int(np.sum(np.isfinite(twins))))
        time = f"{np.median(seconds):.1f} ({np.max(seconds):.1f})"
        rows.append([meaning, _spread(twins), within, _spread(floors), _spread(free), time])
    head = [
        "hidden",
        "torque error after / without the effects",
        "within 5 % of it",
        "after / the tracer's floor",
        "free-run error after / before",
        "processor seconds a trace (worst)",
    ]
    text = (
        "Median and 90th percentile. Without the effects: the error that the tracer leaves on the same vehicle, noise "
        "and command with nothing hidden (every few trials). The tracer's floor is its own estimate."
    )
    return f"{text}\n\n{table(head, rows)}"


def _error(record: Record, part: str) -> Record:
    found: Record = record["error"].get(part, {})
    return found


def _ratio(over: Record, under: Record, key: str = "torque_rmse") -> float:
    numerator, denominator = over.get(key), under.get(key)
    return numerator / denominator if numerator and denominator else float("nan")


def _spread(values: NDArray[np.float64]) -> str:
    known = values[np.isfinite(values)]
    return f"{np.median(known):.3f} ({np.percentile(known, 90):.3f})" if known.size else "–"


def _peers(records: Sequence[Record]) -> str:
    both = [record for record in records if "peers" in record]
    names = ["this project's tracer", *both[0]["peers"]]
    rows = []
    for name in names:
        cells = []
        for group in GROUPS:
            chosen = [record for record in both if record["group"] == group]
            judged = [record["judged"] if name == names[0] else record["peers"][name]["judged"] for record in chosen]
            cells.append(share(sum(each in GOOD for each in judged), len(judged)))
        hidden = [record for record in both if record["group"] != "quiet"]
        named = [record["named"] if name == names[0] else record["peers"][name]["named"] for record in hidden]
        extra = [len(set(each) - set(record["effects"])) for each, record in zip(named, hidden, strict=True)]
        holds = sum(set(record["effects"]) <= set(each) for each, record in zip(named, hidden, strict=True))
        rows.append([name, *cells, share(holds, len(hidden)), f"{np.mean(extra):.1f}" if extra else "–"])
    text = (
        "Right or class; with nothing hidden: nothing named. The peers get the same recordings, filtered, with the "
        "damping projected out, the same vocabulary as terms and thresholds by BIC "
        "(`benchmarks/tracer/innovation_peers.py`). The last columns: the hidden set is among what is named, and how "
        "many others are named in the mean."
    )
    head = ["method", *GROUPS.values(), "names the hidden among others", "others named"]
    return f"{text}\n\n{table(head, rows)}"


def _misses(records: Sequence[Record]) -> str:
    rows = [
        [
            f"{record['group']}:{record['seed']}",
            " + ".join(record["effects"]) or "nothing",
            ", ".join(name + _others(others) for name, others in record["named"].items())
            or record["failure"]
            or "nothing",
            record["judged"],
            record["excitation"],
            record["vehicle"],
            record["autocorrelation"],
            f"{record['evidence']:.0f}",
        ]
        for record in records
        if record["judged"] not in GOOD
    ]
    if not rows:
        return "None."
    head = ["case (`--only`)", "hidden", "named (cannot tell from)", "judged", "excitation", "vehicle", "ρ", "evidence"]
    return table(head, rows)


def _others(names: Sequence[str]) -> str:
    return f" ({', '.join(names)})" if names else ""
