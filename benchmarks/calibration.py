"""Whether the p-values of the weak form are what they claim, where nothing is hidden: how often each effect's is small.

Each effect of the catalogue is fitted alone to logs of vehicles that lack nothing, and its p-value is that of the
report, corrected for its own starts but not for the other effects. A p-value that holds lies below 0.05 in at most 5 %
of the logs. The torque is the command as it was given, which is what most logs hold.

    python -m benchmarks.calibration --seeds 40 --first-seed 860000
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

from benchmarks.provenance import provenance, publish
from benchmarks.trace_cases import AUTOCORRELATIONS
from benchmarks.trace_judge import interval
from benchmarks.trace_table import as_run
from incsvr.effects import candidates
from incsvr.errors import BadInput
from incsvr.tracing.statistics import p_value
from incsvr.tracing.weak.evidence import evidence
from incsvr.tracing.weak.hypothesis import nothing
from incsvr.tracing.weak.posing import pose
from incsvr.tracing.weak.scan import scan, with_lead
from simulator.trial import Trial, play
from simulator.trial_command import EXCITATIONS

RESULTS = Path(__file__).parent / "results"
DURATION = 360.0
"""Of a log [s]."""
LEVELS = (0.05, 0.01, 1e-4)
"""How small a p-value is counted; the last is what a named effect must be below, after the search."""


def examine(case: tuple[int, str, float]) -> list[dict[str, Any]]:
    """The p-value of each effect of one log in which nothing is hidden."""
    seed, excitation, autocorrelation = case
    vehicle = ("leng", "small")[seed % 2]
    outcome = play(Trial(seed, (), 1.0, vehicle, excitation, autocorrelation, DURATION, "commanded"))
    problem = pose([as_run(outcome)], outcome.inertia, [], zero_order_hold=True)
    base, found = nothing(problem), []
    for effect in candidates([]):
        try:
            lead = max(scan(problem, base, [effect]), key=lambda each: each.score, default=None)
            fitted = None if lead is None else with_lead(problem, base, lead)
            p = 1.0 if fitted is None else _p_value(problem, fitted)
        except (BadInput, ArithmeticError):  # what cannot be fitted is not named
            p = 1.0
        found.append({"effect": effect.key, "excitation": excitation, "autocorrelation": autocorrelation, "p": p})
    return found


def _p_value(problem: Any, fitted: Any) -> float:
    """As in the report, for its own starts alone."""
    effect = fitted.effects[0]
    return p_value(evidence(problem, fitted, 0), effect.core + len(effect.sought), effect.looks)


def rows(records: list[dict[str, Any]], by: str) -> Iterable[str]:
    """One row for each value of a column."""
    yield f"| {by} | p-values | " + " | ".join(f"below {level:g}" for level in LEVELS) + " |"
    yield "|---|---|" + "---|" * len(LEVELS)
    for value in dict.fromkeys(record[by] for record in records):
        p = [record["p"] for record in records if record[by] == value]
        cells = []
        for level in LEVELS:
            below = sum(each < level for each in p)
            low, high = interval(below, len(p))
            cells.append(f"{100 * below / len(p):.1f} % ({100 * low:.1f}–{100 * high:.1f})")
        yield f"| {value} | {len(p)} | " + " | ".join(cells) + " |"


def report(document: dict[str, Any]) -> str:
    """Markdown."""
    parts = ["\n".join(rows(document["records"], by)) for by in ("autocorrelation", "excitation", "effect")]
    return (
        f"# p-values where nothing is hidden\n\nMade by `{document['command']}` on {document['date']}, "
        f"{document['processor']}, seeds from {document['first_seed']}: {document['logs']} logs of {DURATION:g} s. "
        "Share of p-values below a level, with Wilson's 95 % interval; a p-value that holds is below the level no more "
        "often than it says. Rows of one log are not independent, so that the intervals of the first two tables are "
        "narrower than they ought to be.\n\n" + "\n\n".join(parts) + "\n"
    )


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--seeds", type=int, default=40, help="logs of each excitation (40)")
    parser.add_argument("--first-seed", type=int, default=860_000, help="the first seed (860000)")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1, help="at once; all cores")
    parser.add_argument("--out", metavar="DIR", type=Path, default=RESULTS, help="where calibration.json and .md go")


def run(args: argparse.Namespace) -> int:
    command = f"python -m benchmarks.calibration --seeds {args.seeds} --first-seed {args.first_seed}"
    cases = [
        (args.first_seed + number * len(EXCITATIONS) + place, excitation, AUTOCORRELATIONS[number % 4])
        for number in range(args.seeds)
        for place, excitation in enumerate(EXCITATIONS)
    ]
    document = provenance(command) | {"first_seed": args.first_seed, "logs": len(cases)}
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the processes are the parallel ones
    with ProcessPoolExecutor(args.processes, multiprocessing.get_context("spawn")) as pool:
        document["records"] = [record for found in pool.map(examine, cases) for record in found]
    publish(args.out, "calibration", document, report(document))
    return 0


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_arguments(parser)
    raise SystemExit(run(parser.parse_args()))
