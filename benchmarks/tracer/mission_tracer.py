"""What the tracer names on ordinary missions, with nothing hidden and with an effect of full size."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from statistics import median

from benchmarks.study import Record
from benchmarks.tables import counted, grouped, share, table
from benchmarks.tracer.answer import answer
from benchmarks.tracer.judge import GOOD, judge
from benchmarks.tracer.mission_cases import HIDDEN, IDLE_KINDS, circumstance
from simulator.missions import Outcome


def examine(group: str, outcome: Outcome) -> Record:
    """A record: the mission's log through the tracer, judged by what was hidden."""
    mission, found = outcome.mission, answer(outcome.recording, outcome.inertia)
    return {
        "group": group,
        "kind": mission.kind,
        "vehicle": mission.vehicle,
        "seed": mission.seed,
        "circumstance": circumstance(mission),
        "hidden": mission.effect,
        "truth": outcome.truth,
        **found,
        "judged": next((key for key in ("failed", "refused") if found[key]), None)
        or verdict(mission.effect, found["named"]),
        "parameter_error": parameter_error(mission.effect, outcome.truth, found["parameters"]),
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
    rows = [
        _quiet(cell, kind, vehicle)
        for kind, own in grouped(records, "kind").items()
        for vehicle, cell in grouped(own, "vehicle").items()
    ]
    drive = [record for record in records if record["kind"] not in IDLE_KINDS]
    hardly = [record for record in records if record["kind"] in IDLE_KINDS]
    for name, chosen in (("all that drive", drive), ("all that hardly drive", hardly), ("all", records)):
        if chosen:
            rows.append(_quiet(chosen, f"**{name}**", ""))
    by_log = [_quiet(own, name, "") for name, own in grouped(records, "circumstance").items()]
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
        counted(named),
        f"{median(record['seconds'] for record in records):.1f}, {max(record['seconds'] for record in records):.1f}",
    ]


def report_hidden(records: Sequence[Record], by: str) -> str:
    """Markdown: what is found of every hidden effect, and below it of all, for each value of the record's key `by`."""
    effects = grouped([record | {"one": _one(record["hidden"])} for record in records], "one")
    rows = [_found(effects[effect], effect) for effect in HIDDEN if effect in effects]
    rows += [_found(own, f"*{value}*") for value, own in grouped(records, by).items()]
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
        counted(beside),
    ]


def sentences(records: Sequence[Record], key: str) -> str:
    """Markdown: the refusals ("refused") or tracebacks ("failed"), and how often each was met, without its figures."""
    met = Counter(f"{record['kind']}: {record[key]}" for record in records if record[key])
    return "\n".join(f"- {sentence} ({count})" for sentence, count in met.most_common()) or "None."
