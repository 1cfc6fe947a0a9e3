"""The tracer's confusion matrix and its false alarms, beside its peers on the same recordings.

`make trace-table`, or `python -m benchmarks.tracer.trace_table --only one:10007` for one case again. `--noise` says
what the torque is and where the noise is (simulator/trial.py); each of the three has a table of its own.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import random
import shlex
import sys
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import asdict, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from benchmarks.study import RESULTS
from benchmarks.tracer import innovation_peers as peers
from benchmarks.tracer.judge import judge
from benchmarks.tracer.trace_cases import GROUPS, case
from benchmarks.tracer.trace_report import report
from incsvr.signals.settings import TorqueKind
from incsvr.tracing import trace
from incsvr.tracing.findings import Trace
from incsvr.tracing.run import Run
from service.wire.json_text import json_text
from simulator.trial import Outcome, TorqueNoise, Trial, play

TABLES: Mapping[TorqueNoise, str] = {
    "commanded": "trace_table",
    "measured": "trace_table_measured",
    "torque": "trace_table_torque",
}
"""Where the trials with each kind of noise are told: names of the two files."""
FIRST_SEED = 2_000_000
"""Seeds from here on are for the published table alone; whoever improves the tracer tries it on smaller ones."""


def examine(group: str, trial: Trial, in_depth: bool, told: bool) -> dict[str, Any]:
    """Plays a trial, has it traced, and judges the answer; a plain record, for JSON.

    In depth: the peers see it, and the tracer sees the trial without its effects, whose error is the floor.
    """
    outcome = play(trial)
    # The weaker of two decides whether both can be found.
    evidence = min([play(replace(trial, effects=(name,))).evidence for name in trial.effects], default=0.0)
    run = as_run(outcome)
    # Processor time: a busy machine must not make the tracer look slow.
    began = time.process_time()
    failure, answer = None, dict[str, Any]()
    try:
        answer = traced(outcome, told).to_dict()
    except Exception as error:  # a crash is a result too, and the other trials go on
        failure = f"{type(error).__name__}: {error}"
    seconds = time.process_time() - began
    effects = answer.get("effects", [])
    named = {effect["effect"]: effect["cannot_tell_from"] for effect in effects}
    record: dict[str, Any] = {
        "group": group,
        **asdict(trial),
        "truth": outcome.truth,
        "evidence": evidence,
        "failure": failure,
        "verdict": answer.get("verdict"),
        "named": named,
        "judged": "failed" if failure else judge(trial.effects, named),
        "p_values": {effect["effect"]: effect["p_value"] for effect in effects},
        "parameters": {effect["effect"]: effect["parameters"] for effect in effects},
        "unexplained": [each["channel"] for each in answer.get("unexplained", [])],
        "error": answer.get("error", {}),
        "seconds": seconds,
    }
    if in_depth and trial.effects:
        twin = play(replace(trial, size=0.0))
        record["twin"] = traced(twin, told).to_dict()["error"]["before"]
    if in_depth:
        problem = peers.terms(run, outcome.inertia)
        record["peers"] = {}
        for name, select in peers.PEERS.items():
            theirs = peers.answer(problem, select(problem))
            record["peers"][name] = {"named": sorted(theirs), "judged": judge(trial.effects, theirs)}
    return record


def traced(outcome: Outcome, told: bool) -> Trace:
    """What the tracer finds, who may be told whether the torque is a command."""
    kind = torque_kind(outcome.trial.noise) if told else None
    return trace([as_run(outcome)], inertia=outcome.inertia, torque=kind)


def torque_kind(noise: TorqueNoise) -> TorqueKind:
    """What the torque of trials with this noise is."""
    return "commanded" if noise == "commanded" else "measured"


def as_run(outcome: Outcome) -> Run:
    """The recording as the tracer takes it: it sees nothing else of the outcome."""
    columns = dict(outcome.recording.columns)
    return Run(outcome.recording.name, outcome.recording.time, columns.pop("yaw_rate"), columns.pop("torque"), columns)


def study(work: Sequence[tuple[str, Trial, bool, bool]], processes: int, at_most: float) -> list[dict[str, Any]]:
    """The records of the cases, by group and seed, with a progress bar on standard error.

    Args:
        work: arguments for `examine`.
        processes: how many work at once.
        at_most: after so many seconds no further case is begun.
    """
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    records: dict[int, dict[str, Any]] = {}
    pending: dict[Future[dict[str, Any]], int] = {}
    # One core a process; the processes that are spawned load NumPy anew and see this.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    end = time.monotonic() + at_most
    with (
        ProcessPoolExecutor(processes, multiprocessing.get_context("spawn")) as pool,
        Progress(*columns, console=Console(stderr=True)) as progress,
    ):
        task = progress.add_task("tracing trials", total=len(work))
        for position, item in enumerate(work):
            if time.monotonic() > end:
                break
            pending[pool.submit(examine, *item)] = position
            if len(pending) >= processes:
                finished, _ = wait(pending, return_when=FIRST_COMPLETED)
                records.update({pending.pop(future): future.result() for future in finished})
                progress.update(task, completed=len(records))
        records.update({position: future.result() for future, position in pending.items()})
        progress.update(task, completed=len(records))
    return [
        records[position]
        for position in sorted(records, key=lambda position: (work[position][0], work[position][1].seed))
    ]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of the study."""
    parser.add_argument("--first-seed", type=int, default=FIRST_SEED)
    parser.add_argument("--one", type=int, default=120, help="trials with one effect (default: %(default)s)")
    parser.add_argument("--half", type=int, default=120, help="the same at half the size (default: %(default)s)")
    parser.add_argument("--two", type=int, default=60, help="trials with two effects (default: %(default)s)")
    parser.add_argument("--quiet", type=int, default=200, help="trials with nothing hidden (default: %(default)s)")
    parser.add_argument(
        "--noise",
        choices=list(TABLES),
        default="commanded",
        help="the torque is the command; it is measured; or all noise is in its sensor (default: %(default)s)",
    )
    parser.add_argument("--told", action="store_true", help="tell the tracer whether the torque is a command")
    parser.add_argument("--minutes", type=float, default=12.0, help="length of a recording (default: %(default)s)")
    parser.add_argument(
        "--deep-every", type=int, default=0, metavar="N", help="peers and floors for every Nth trial; 0: none"
    )
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument(
        "--at-most", type=float, default=180.0, metavar="MINUTES", help="begin no trial after that long"
    )
    parser.add_argument("--only", metavar="GROUP:SEED", help="one case again, printed instead of written")
    parser.add_argument("--out", type=Path, default=RESULTS, help="folder of the results (default: %(default)s)")


def run(args: argparse.Namespace) -> int:
    """Writes the two files of the table."""
    if args.only:
        group, _, seed = args.only.partition(":")
        trial = case(group, int(seed) - args.first_seed, args.first_seed, 60 * args.minutes)
        record = examine(group, replace(trial, noise=args.noise), True, args.told)
        print(json_text(record, indent=2))
        return 0
    every, counts = args.deep_every, {group: getattr(args, group) for group in GROUPS}
    indices = [(group, index) for group, count in counts.items() for index in range(count)]
    # In random order, so that a study that stops early is a smaller study of the same kind.
    random.Random(args.first_seed).shuffle(indices)
    work = [
        (
            group,
            replace(case(group, index, args.first_seed, 60 * args.minutes), noise=args.noise),
            every > 0 and index % every == 0,
            args.told,
        )
        for group, index in indices
    ]
    began = time.perf_counter()
    records = study(work, args.processes, 60 * args.at_most)
    document = {
        "command": shlex.join(["python", "-m", "benchmarks.tracer.trace_table", *sys.argv[1:]]),
        "date": datetime.now(UTC).date().isoformat(),
        "first_seed": args.first_seed,
        "minutes": round((time.perf_counter() - began) / 60, 1),
        "planned": len(work),
        "records": records,
    }
    args.out.mkdir(parents=True, exist_ok=True)
    text = report(document)
    lines = ",\n".join(json_text(record) for record in records)
    head = json_text({key: value for key, value in document.items() if key != "records"})[:-1]
    name = TABLES[args.noise] + "_told" * args.told
    (args.out / f"{name}.json").write_text(f'{head}, "records": [\n{lines}\n]}}\n', encoding="utf-8")
    (args.out / f"{name}.md").write_text(text, encoding="utf-8")
    print(text)
    return 0


def main() -> int:
    """The command line of the study."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.tracer.trace_table", description=__doc__)
    add_arguments(parser)
    return run(parser.parse_args())


if __name__ == "__main__":
    sys.exit(main())
