"""The study's records as tables that people read."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks.study import Record
from benchmarks.tables import counted, grouped, page, share, table
from benchmarks.tracer.judge import GOOD, VERDICTS
from benchmarks.tracer.trace_cases import GROUPS
from simulator.trial_command import EXCITATIONS

NOISE = {
    "commanded": "a torque that is the command as it was given, 10, 20 or 40 times a second, in two of five recordings "
    "rounded to 1 to 2.5 % of the full torque; all noise of the residual in the water",
    "measured": "a torque that is measured, with white noise, 1 % outliers and often coarse steps; what lasts of the "
    "residual's noise in the water",
}
"""What the torque is, and where the noise is (simulator/trial_sensors.py)."""
MIN_VISIBLE_EVIDENCE = 20.0
"""Expected evidence below which the hidden effect is not in the data, for a reader who knows its shape and parameters.

Twice a log-likelihood ratio. Such trials are counted like all others; the last column says how many there are.
"""


def report(document: Record) -> str:
    """Markdown."""
    records: list[Record] = document["records"]
    groups = grouped(records, "group")
    return page(
        "# What the tracer names when something is hidden",
        f"Made by `{document['command']}` on {document['date']}, seeds from {document['first_seed']}, "
        f"{len(records)} of {document['planned']} planned recordings of {records[0]['duration'] / 60:.0f} minutes "
        f"with a gyro at about 20 Hz, traced in {document['minutes']} minutes.",
        "The vehicles come from `simulator/trial.py`, which shares nothing with the tracer: drag that is no "
        f"polynomial; {NOISE[records[0]['noise']]}; a noisy gyro, which the controller in closed loop sees, too; in "
        "half of the recordings streams on their own clocks; idle channels. Noise: 3.5 % of the full torque (3.5 N m "
        "at the paper's scale), residual autocorrelation over 0.05 s as given, in trials with effects 0, 0.5 or 0.9.",
        _summary(groups),
        "\n".join(f"- {name}: {meaning}." for name, meaning in VERDICTS.items()),
        f"Invisible: trials whose evidence is below {MIN_VISIBLE_EVIDENCE:g} for a reader who knows the effect's shape "
        "and parameters and the noise; they count like the others.",
        "## False alarms with nothing hidden",
        _alarms(groups.get("quiet", [])),
        *(
            part
            for name in ("one", "half")
            if name in groups
            for part in (f"## {GROUPS[name].capitalize()}", _confusion(groups[name]))
        ),
        "## After-error, parameters and time",
        _quality(groups),
        "## Every miss",
        _misses(records),
    )


def _summary(groups: dict[str, list[Record]]) -> str:
    rows = []
    for group in (name for name in GROUPS if name in groups):
        chosen = groups[group]
        counts = Counter(record["judged"] for record in chosen)
        good = sum(counts[verdict] for verdict in GOOD)
        invisible = sum(record["evidence"] < MIN_VISIBLE_EVIDENCE for record in chosen) if group != "quiet" else "–"
        cells = [counts[verdict] for verdict in (*VERDICTS, "failed")]
        shares = share(good, len(chosen)), share(good + counts["joint"], len(chosen))
        rows.append([GROUPS[group], len(chosen), *cells, *shares, invisible])
    head = ["hidden", "runs", *VERDICTS, "failed", "right or class (95 %)", "or joint (95 %)", "invisible"]
    return table(head, rows)


def _alarms(quiet: Sequence[Record]) -> str:
    rows = []
    for level, chosen in sorted(grouped(quiet, "autocorrelation").items()):
        false = sum(bool(record["named"]) for record in chosen)
        unexplained = sum(record["verdict"] == "unexplained" for record in chosen)
        named = counted(Counter(name for record in chosen for name in record["named"]))
        failed = sum(bool(record["failure"]) for record in chosen)
        rows.append([level, len(chosen), failed, false, share(false, len(chosen) - failed), unexplained, named])
    head = ["residual autocorrelation", "runs", "failed", "with a false effect", "share (95 %)", "“unexplained”"]
    return table([*head, "named"], rows)


def _confusion(records: Sequence[Record]) -> str:
    rows = []
    for kind, mine in grouped([record | {"kind": _kind(record)} for record in records], "kind").items():
        under = grouped(mine, "excitation")
        wrong = Counter(name for record in mine for name in record["named"] if name not in record["effects"])
        rows.append([kind, *(_cell(under.get(each, [])) for each in EXCITATIONS), _cell(mine), counted(wrong, 4)])
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


def _quality(groups: dict[str, list[Record]]) -> str:
    rows = []
    for group in (name for name in GROUPS if name in groups):
        chosen = [record for record in groups[group] if not record["failure"]]
        if chosen:
            errors = [record["error"] for record in chosen]
            floors = np.array([_ratio(each["after"], each["floor"], "torque_rmse") for each in errors])
            free = np.array([_ratio(each["after"], each["before"], "free_run_rmse") for each in errors])
            seconds = [record["seconds"] for record in chosen]
            time = f"{np.median(seconds):.1f} ({np.max(seconds):.1f})"
            rows.append([GROUPS[group], _spread(floors), _spread(free), time])
    ratios = ["torque error after / the tracer's floor", "free-run error after / before"]
    text = "Median and 90th percentile. The tracer's floor is its own estimate."
    return f"{text}\n\n{table(['hidden', *ratios, 'processor seconds a trace (worst)'], rows)}"


def _ratio(over: Record, under: Record, key: str) -> float:
    numerator, denominator = over.get(key), under.get(key)
    return numerator / denominator if numerator and denominator else float("nan")


def _spread(values: NDArray[np.float64]) -> str:
    known = values[np.isfinite(values)]
    return f"{np.median(known):.3f} ({np.percentile(known, 90):.3f})" if known.size else "–"


def _misses(records: Sequence[Record]) -> str:
    rows = [
        [
            f"{record['group']}:{record['seed']}",
            " + ".join(record["effects"]) or "nothing",
            ", ".join(name + _others(others) for name, others in record["named"].items())
            or record["failure"]
            or "nothing",
            *(record[key] for key in ("judged", "excitation", "vehicle", "autocorrelation")),
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
