"""Which point the grid search of Section IV-B chooses on the simulated T1, seed by seed.

`make tuning`. All 64 points of the paper's grid are tried on every seed by the paper's learner, judged after every
training step as the paper's text says, and after the last step alone.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.paper.repetition import LEARNERS
from benchmarks.study import begin, in_processes, options, publish
from benchmarks.tables import page, table
from incsvr.learning.tuning import PAPER_POINT, Grid, Judged, Trial, ranked, search
from simulator import leng

WAYS: Mapping[Judged, str] = {"every": "after every training step, averaged", "last": "after the last step alone"}

Point = tuple[float, float, float]


def examine(seed: int) -> list[Trial]:
    """The trials of all points on one seed."""
    return list(search(leng.experiment(seed).T1, LEARNERS["paper"]))


def report(found: Sequence[Sequence[Trial]], heading: str) -> str:
    """Markdown.

    Args:
        found: the trials of each seed.
        heading: command and date.
    """
    ranks: dict[Judged, dict[Point, list[int]]] = {way: _ranks(found, way) for way in WAYS}
    parts = []
    for way, words in WAYS.items():
        winners = Counter(ranked(trials, way)[0].point for trials in found)
        mine, errors = ranks[way][PAPER_POINT], [getattr(_at(trials, PAPER_POINT), way) for trials in found]
        least = [getattr(ranked(trials, way)[0], way) for trials in found]
        parts.append(
            f"Judged **{words}**: the paper's point ranks {min(mine)} to {max(mine)}, {np.median(mine):g} in the "
            f"median, with {np.mean(errors):.2f} N m where the best has {np.mean(least):.2f}. Chosen: "
            + "; ".join(f"{_named(point)} in {count}" for point, count in winners.most_common())
            + f" of {len(found)}."
        )
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
    every, last = ([f"{name} step, N m", "rank", "first in"] for name in ("every", "last"))
    return page(
        "# The grid search of Section IV-B on the simulated T1",
        heading,
        f"The paper's policy, {len(Grid())} points, one batch of 14 left out at a time, nothing random. The "
        "paper chose C = 1000 N m, ε = 0.1 N m, γ = 10 s²/rad².",
        *parts,
        table(["C N m", "ε N m", "γ s²/rad²", *every, *last, ""], rows),
    )


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


def main(words: Sequence[str] | None = None) -> None:
    parser = options(
        "benchmarks.paper.tuning",
        __doc__,
        seeds=(20, "repetitions of T1"),
        first_seed=(0, "of the first"),
        processes=(1, "repetitions at once"),
    )
    args, measured = begin(parser, words)
    seeds = range(args.first_seed, args.first_seed + args.seeds)
    text = report(in_processes(examine, seeds, "seeds", args.processes), f"`{measured['command']}`, {measured['date']}")
    publish(args.out, "tuning", measured, text)


if __name__ == "__main__":
    main()
