"""Which point the grid search of Section IV-B chooses on the simulated T1, seed by seed.

    python -m benchmarks.paper.tuning

All 64 points of the paper's grid are tried on every seed by the paper's learner, judged after every training step as
the paper's text says, and after the last step alone.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from time import process_time

import numpy as np

from benchmarks.paper.repetition import LEARNERS
from benchmarks.study import RESULTS, provenance
from benchmarks.tables import table
from incsvr.learning.tuning import PAPER_POINT, Grid, Judged, Trial, ranked, search
from service.cli.progress import progress
from simulator import leng

RESULT = RESULTS / "tuning.md"
WAYS: Mapping[Judged, str] = {"every": "after every training step, averaged", "last": "after the last step alone"}

Point = tuple[float, float, float]


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.paper.tuning", description=__doc__)
    parser.add_argument("--seeds", type=int, default=20, metavar="N", help="repetitions of T1 (20)")
    parser.add_argument("--first-seed", type=int, default=0, metavar="SEED", help="of the first repetition (0)")
    parser.add_argument("--out", type=Path, default=RESULT, metavar="FILE", help="where the table goes")
    args = parser.parse_args()
    began, found = process_time(), list[list[Trial]]()
    with progress("seeds", args.seeds) as advance:
        for seed in range(args.first_seed, args.first_seed + args.seeds):
            found.append(list(search(leng.experiment(seed).T1, LEARNERS["paper"])))
            advance()
    command = f"python -m benchmarks.paper.tuning --seeds {args.seeds} --first-seed {args.first_seed}"
    measured = provenance(command)
    heading = f"`{command}`, {measured['date']}, {(process_time() - began) / args.seeds:.0f} s of a core a seed"
    text = report(found, heading)
    args.out.write_text(text, encoding="utf-8")
    print(text, file=sys.stdout)
    return 0


def report(found: Sequence[Sequence[Trial]], heading: str) -> str:
    """Markdown.

    Args:
        found: the trials of each seed.
        heading: command, date and cost.
    """
    ranks: dict[Judged, dict[Point, list[int]]] = {way: _ranks(found, way) for way in WAYS}
    lines = [
        "# The grid search of Section IV-B on the simulated T1",
        "",
        heading,
        "",
        f"The paper's policy, {len(Grid())} points, one batch of 14 left out at a time, nothing random. The "
        "paper chose C = 1000 N m, ε = 0.1 N m, γ = 10 s²/rad².",
        "",
    ]
    for way, words in WAYS.items():
        winners = Counter(ranked(trials, way)[0].point for trials in found)
        mine, errors = ranks[way][PAPER_POINT], [getattr(_at(trials, PAPER_POINT), way) for trials in found]
        least = [getattr(ranked(trials, way)[0], way) for trials in found]
        lines += [
            f"Judged **{words}**: the paper's point ranks {min(mine)} to {max(mine)}, {np.median(mine):g} in the "
            f"median, with {np.mean(errors):.2f} N m where the best has {np.mean(least):.2f}. Chosen: "
            + "; ".join(f"{_named(point)} in {count}" for point, count in winners.most_common())
            + f" of {len(found)}.",
            "",
        ]
    rows = []
    for point in sorted(ranks["every"], key=lambda each: float(np.mean(ranks["every"][each]))):
        cells = [f"{number:g}" for number in point]
        for way in WAYS:
            values = [getattr(_at(trials, point), way) for trials in found]
            cells.append(f"{np.mean(values):.2f} ± {np.std(values, ddof=1) if len(values) > 1 else 0.0:.2f}")
            mine = ranks[way][point]
            cells.append(f"{np.mean(mine):.1f} ({min(mine)}–{max(mine)})")
            cells.append(str(sum(rank == 1 for rank in mine)))
        rows.append([*cells, "← the paper's" if point == PAPER_POINT else ""])
    head = [
        "C N m",
        "ε N m",
        "γ s²/rad²",
        "every step, N m",
        "rank",
        "first in",
        "last step, N m",
        "rank",
        "first in",
        "",
    ]
    return "\n".join([*lines, table(head, rows), ""])


def _ranks(found: Sequence[Sequence[Trial]], way: Judged) -> dict[Point, list[int]]:
    """Each point's rank on every seed."""
    ranks: dict[Point, list[int]] = {}
    for trials in found:
        for rank, trial in enumerate(ranked(trials, way), start=1):
            ranks.setdefault(trial.point, []).append(rank)
    return ranks


def _at(trials: Sequence[Trial], point: Point) -> Trial:
    return next(trial for trial in trials if trial.point == point)


def _named(point: Point) -> str:
    return "{{{:g}, {:g}, {:g}}}".format(*point)


if __name__ == "__main__":
    sys.exit(main())
