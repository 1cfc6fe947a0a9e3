"""What the tracer names on ordinary missions, with nothing hidden and with an effect of full size."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Mapping, Sequence
from statistics import median
from typing import Any

from benchmarks.tables import share, table
from benchmarks.tracer.judge import GOOD, judge
from benchmarks.tracer.mission_cases import HIDDEN, IDLE, circumstance
from incsvr.errors import BadInput
from incsvr.tracing import trace
from incsvr.tracing.run import Run
from simulator.missions import Outcome

Record = dict[str, Any]


def examine(group: str, outcome: Outcome) -> Record:
    """A record: the mission's log through the tracer, judged by what was hidden."""
    mission = outcome.mission
    columns = dict(outcome.recording.columns)
    rate, torque = columns.pop("yaw_rate"), columns.pop("torque")
    run = Run(outcome.recording.name, outcome.recording.time, rate, torque, columns)
    # Processor time: a busy machine must not make the tracer look slow.
    began = time.process_time()
    answer, refused, failed = dict[str, Any](), None, None
    try:
        answer = trace([run], inertia=outcome.inertia).to_dict()
    except BadInput as refusal:
        refused = str(refusal)
    except Exception as error:  # a crash is a result too, and the other missions go on
        failed = f"{type(error).__name__}: {error}"
    effects = answer.get("effects", [])
    named = {effect["effect"]: list(effect["cannot_tell_from"]) for effect in effects}
    parameters = {effect["effect"]: effect["parameters"] for effect in effects}
    return {
        "group": group,
        "kind": mission.kind,
        "vehicle": mission.vehicle,
        "seed": mission.seed,
        "circumstance": circumstance(mission),
        "hidden": mission.effect,
        "truth": outcome.truth,
        "refused": refused,
        "failed": failed,
        "verdict": answer.get("verdict"),
        "loop": answer.get("loop"),
        "proven": answer.get("proven"),
        "named": named,
        "parameters": parameters,
        "p_values": {effect["effect"]: effect["p_value"] for effect in effects},
        "judged": "failed" if failed else "refused" if refused else verdict(mission.effect, named),
        "parameter_error": parameter_error(mission.effect, outcome.truth, parameters),
        "seconds": time.process_time() - began,
    }


def verdict(hidden: str | None, named: Mapping[str, Sequence[str]]) -> str:
    """One of benchmarks.tracer.judge.VERDICTS, where two forms of one effect count as one."""
    merged: dict[str, set[str]] = {}
    for effect, rivals in named.items():
        merged.setdefault(_one(effect), set()).update(_one(rival) for rival in rivals)
    return judge(() if hidden is None else (_one(hidden),), merged)


def _one(effect: str) -> str:
    return next((name for name, forms in HIDDEN.items() if effect in forms), effect)


def parameter_error(
    hidden: str | None, truth: Mapping[str, float | str], parameters: Mapping[str, Mapping[str, float]]
) -> float | None:
    """Of the hidden effect's first parameter, in parts of the true one; None where it was not found in that form."""
    if hidden is None or hidden not in parameters:
        return None
    name = next(iter(truth))
    true, found = truth[name], parameters[hidden].get(name)
    return None if found is None or isinstance(true, str) else abs(found / true - 1.0)


def report_quiet(records: Sequence[Record]) -> str:
    """Markdown: what is named where nothing is hidden, for each kind and vehicle, and under each circumstance."""
    cells = dict.fromkeys((record["kind"], record["vehicle"]) for record in records)
    rows = [_quiet([r for r in records if (r["kind"], r["vehicle"]) == cell], *cell) for cell in cells]
    for name, chosen in (
        ("**all that drive**", [record for record in records if record["kind"] not in IDLE]),
        ("**all that hardly drive**", [record for record in records if record["kind"] in IDLE]),
        ("**all**", records),
    ):
        if chosen:
            rows.append(_quiet(chosen, name, ""))
    by_log = [
        _quiet([record for record in records if record["circumstance"] == name], name, "")
        for name in dict.fromkeys(record["circumstance"] for record in records)
    ]
    tail = ["runs", "with a false effect (95 %)", "tracebacks", "refused", "“unexplained”", "named", "seconds, largest"]
    return "\n\n".join((table(["mission", "vehicle", *tail], rows), table(["log", "", *tail], by_log)))


def _quiet(records: Sequence[Record], name: str, vehicle: str) -> list[object]:
    named = Counter(effect for record in records for effect in record["named"])
    return [
        name,
        vehicle,
        len(records),
        share(sum(bool(record["named"]) for record in records), len(records)),
        sum(record["failed"] is not None for record in records),
        sum(record["refused"] is not None for record in records),
        sum(record["verdict"] == "unexplained" for record in records),
        ", ".join(f"{effect} {count}" for effect, count in named.most_common()) or "–",
        f"{median(record['seconds'] for record in records):.1f}, {max(record['seconds'] for record in records):.1f}",
    ]


def report_hidden(records: Sequence[Record], by: str) -> str:
    """Markdown: what is found of every hidden effect, and below it of all, for each value of the record's key `by`."""
    rows = [
        _found([record for record in records if _one(record["hidden"]) == effect], effect)
        for effect in HIDDEN
        if any(_one(record["hidden"]) == effect for record in records)
    ]
    values = dict.fromkeys(record[by] for record in records)
    rows += [_found([record for record in records if record[by] == value], f"*{value}*") for value in values]
    rows.append(_found(records, "**all**"))
    head = ["hidden", "runs", "right", "class", "false beside", "missed", "another named", "refused", "tracebacks"]
    return table([*head, "right or class (95 %)", "parameter error, median", "named instead or beside"], rows)


def _found(records: Sequence[Record], name: str) -> list[object]:
    counts = Counter(record["judged"] for record in records)
    errors = [record["parameter_error"] for record in records if record["parameter_error"] is not None]
    beside = Counter(e for record in records for e in record["named"] if _one(e) != _one(record["hidden"]))
    return [
        name,
        len(records),
        *(counts[verdict] for verdict in ("right", "class", "false", "missed", "both", "refused", "failed")),
        share(sum(counts[verdict] for verdict in GOOD), len(records)),
        f"{100 * median(errors):.1f} %" if errors else "–",
        ", ".join(f"{effect} {count}" for effect, count in beside.most_common()) or "–",
    ]


def sentences(records: Sequence[Record], key: str) -> str:
    """Markdown: the refusals ("refused") or tracebacks ("failed"), and how often each was met, without its figures."""
    met = Counter(f"{record['kind']}: {record[key]}" for record in records if record[key])
    return "\n".join(f"- {sentence} ({count})" for sentence, count in met.most_common()) or "None."
