"""What the tracer names on recordings of the second simulator, which shares nothing with it but the files' form.

`make trace-table`. The tracer is not told whether the torque is a command.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from statistics import median

from benchmarks.study import Record, begin, in_processes, options, publish
from benchmarks.tables import grouped, page, share, table
from benchmarks.tracer.answer import answer
from benchmarks.tracer.judge import GOOD, judge
from benchmarks.tracer.second_cases import GROUPS, case, play

FIRST_SEED = 2_100_000
"""Seeds from here on are for the published table alone; whoever improves the tracer tries it on smaller ones."""


def examine(work: tuple[str, int, int]) -> Record:
    """Plays a case, has it traced, and judges the answer."""
    group, index, first_seed = work
    hidden = case(group, index, first_seed)
    outcome = play(hidden)
    found = answer(outcome.recording, outcome.inertia)
    return {
        "group": group,
        "seed": hidden.seed,
        "vehicle": hidden.vehicle,
        "command": hidden.command,
        "torque": hidden.torque,
        "hidden": list(hidden.effects),
        **found,
        "judged": next((key for key in ("failed", "refused") if found[key]), None)
        or judge(hidden.effects, found["named"]),
    }


def report(document: Record) -> str:
    """Markdown."""
    records: Sequence[Record] = document["records"]
    return page(
        "# What is named on the second simulator's recordings",
        f"Made by `{document['command']}` on {document['date']}, seeds from {document['first_seed']}; twelve minutes "
        f"each; processor time {median(r['seconds'] for r in records):.1f} s in the median, "
        f"{max(r['seconds'] for r in records):.1f} s at most.",
        *(_by(records, key) for key in ("group", "torque", "vehicle", "command")),
    )


def _by(records: Sequence[Record], key: str) -> str:
    rows = []
    for value, own in grouped(records, key).items():
        hidden = [record for record in own if record["hidden"]]
        counts = Counter(record["judged"] for record in hidden)
        quiet = [record for record in own if not record["hidden"]]
        rows.append([
            GROUPS.get(value, value),
            share(sum(counts[each] for each in GOOD), len(hidden)),
            *(counts[each] for each in ("missed", "false", "both", "refused", "failed")),
            share(sum(bool(record["named"]) for record in quiet), len(quiet)),
        ])  # fmt: skip
    head = [key, "found (95 %)", "missed", "false beside", "another named", "refused", "tracebacks"]
    return table([*head, "false, nothing hidden (95 %)"], rows)


def main(words: Sequence[str] | None = None) -> None:
    parser = options(
        "benchmarks.tracer.second_table",
        __doc__,
        first_seed=(FIRST_SEED, "of the cases"),
        one=(126, f"cases: {GROUPS['one']}"),
        half=(72, f"cases: {GROUPS['half']}"),
        quiet=(140, f"cases: {GROUPS['quiet']}"),
        processes=(2, "cases at once"),
    )
    args, measured = begin(parser, words)
    work = [
        (group, index, args.first_seed + 10_000 * number)
        for number, group in enumerate(GROUPS)
        for index in range(getattr(args, group))
    ]
    document = measured | {
        "first_seed": args.first_seed,
        "records": in_processes(examine, work, "cases", args.processes),
    }
    publish(args.out, "second_table", document, report(document))


if __name__ == "__main__":
    main()
