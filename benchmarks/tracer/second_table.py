"""What the tracer names on recordings of the second simulator, which shares nothing with it but the files' form.

    python -m benchmarks.tracer.second_table [--first-seed N] [--one N] [--half N] [--quiet N] [--told]

`make trace-table`. The tracer is not told whether the torque is a command, unless asked for.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import shlex
import sys
import time
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from statistics import median
from typing import Any

from benchmarks.study import RESULTS, provenance, publish
from benchmarks.tables import share, table
from benchmarks.tracer.judge import GOOD, judge
from benchmarks.tracer.second_cases import GROUPS, case, play
from incsvr.errors import BadInput
from incsvr.tracing import trace
from incsvr.tracing.run import Run
from service.cli.progress import progress

FIRST_SEED = 2_100_000
"""Seeds from here on are for the published table alone; whoever improves the tracer tries it on smaller ones."""
Record = dict[str, Any]


def examine(work: tuple[str, int, int, bool]) -> Record:
    """Plays a case, has it traced, and judges the answer."""
    group, index, first_seed, told = work
    hidden = case(group, index, first_seed)
    outcome = play(hidden)
    columns = dict(outcome.recording.columns)
    rate, torque = columns.pop("yaw_rate"), columns.pop("torque")
    run = Run(outcome.recording.name, outcome.recording.time, rate, torque, columns)
    began = time.process_time()
    failure, answer = None, dict[str, Any]()
    try:
        answer = trace([run], inertia=outcome.inertia, torque=hidden.torque if told else None).to_dict()
    except BadInput as refusal:
        failure = str(refusal)
    named = {each["effect"]: list(each["cannot_tell_from"]) for each in answer.get("effects", [])}
    about = {"vehicle": hidden.vehicle, "command": hidden.command, "torque": hidden.torque}
    return about | {
        "group": group,
        "seed": hidden.seed,
        "hidden": list(hidden.effects),
        "named": named,
        "refused": failure,
        "judged": "refused" if failure else judge(hidden.effects, named),
        "seconds": time.process_time() - began,
    }


def report(document: dict[str, Any]) -> str:
    """Markdown."""
    records: Sequence[Record] = document["records"]
    parts = [
        "# What is named on the second simulator's recordings",
        f"Made by `{document['command']}` on {document['date']}, seeds from {document['first_seed']}; twelve minutes "
        f"each; processor time {median(r['seconds'] for r in records):.1f} s in the median, "
        f"{max(r['seconds'] for r in records):.1f} s at most.",
    ]
    parts += [_by(records, key) for key in ("group", "torque", "vehicle", "command")]
    return "\n\n".join(parts) + "\n"


def _by(records: Sequence[Record], key: str) -> str:
    rows = []
    for value in dict.fromkeys(record[key] for record in records):
        own = [record for record in records if record[key] == value]
        hidden = [record for record in own if record["hidden"]]
        counts = Counter(record["judged"] for record in hidden)
        false = [record for record in own if not record["hidden"]]
        rows.append([
            GROUPS.get(value, value),
            share(sum(counts[each] for each in GOOD), len(hidden)) if hidden else "–",
            *(str(counts[each]) for each in ("missed", "false", "both", "refused")),
            share(sum(bool(record["named"]) for record in false), len(false)) if false else "–",
        ])  # fmt: skip
    head = [key, "found (95 %)", "missed", "false beside", "another named", "refused", "false, nothing hidden (95 %)"]
    return table(head, rows)


def main() -> int:
    """The command line of the study."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.tracer.second_table", description=__doc__)
    parser.add_argument("--first-seed", type=int, default=FIRST_SEED)
    for group, count in (("one", 126), ("half", 72), ("quiet", 140)):
        parser.add_argument(f"--{group}", type=int, default=count, help=f"cases: {GROUPS[group]} (default: {count})")
    parser.add_argument("--told", action="store_true", help="tell the tracer whether the torque is a command")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--out", type=Path, default=RESULTS)
    args = parser.parse_args()
    work = [
        (group, index, args.first_seed + 10_000 * number, args.told)
        for number, group in enumerate(GROUPS)
        for index in range(getattr(args, group))
    ]
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    records = []
    with (
        ProcessPoolExecutor(args.processes, multiprocessing.get_context("spawn")) as pool,
        progress("cases", len(work)) as advance,
    ):
        for record in pool.map(examine, work):
            records.append(record)
            advance()
    command = shlex.join(["python", "-m", "benchmarks.tracer.second_table", *sys.argv[1:]])
    document = provenance(command) | {"first_seed": args.first_seed, "records": records}
    name = "second_table" + "_told" * args.told
    publish(args.out, name, document, report(document))
    return 0


if __name__ == "__main__":
    sys.exit(main())
