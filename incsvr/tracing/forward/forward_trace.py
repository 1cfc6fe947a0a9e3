"""From recordings to what the declared model lacks, by the forward form alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.tracing.findings import Trace
from incsvr.tracing.forward.candidates import admissible
from incsvr.tracing.forward.fit import fit
from incsvr.tracing.forward.grid import cells
from incsvr.tracing.forward.question import Question
from incsvr.tracing.forward.result import result_of
from incsvr.tracing.forward.search import search
from incsvr.tracing.run import Run


def forward_trace(
    runs: Sequence[Run],
    inertia: float,
    validate: Sequence[Run] | None,
    names: Sequence[str],
    ignored: dict[str, str],
) -> Trace:
    """What the declared model lacks where a controller closed the loop with commands.

    Args:
        runs: the recordings to fit.
        inertia: I₀, declared [kg m²].
        validate: recordings for the proof alone; without them pieces of `runs` are held out.
        names: of the channels that may be candidates.
        ignored: why others may not.

    Raises:
        BadInput: where the recordings cannot answer.
    """
    channels = read(runs, names)
    grid = cells(runs, inertia, channels)
    base = fit(grid)
    question = Question.of(grid, admissible(names, grid.signals), base)
    validation_grid = cells(validate, inertia, channels) if validate else None
    return result_of(question, search(question, base), validation_grid, ignored)


def read(runs: Sequence[Run], names: Sequence[str]) -> list[str]:
    """The channels that are read: the candidates', and the heading where every run has one."""
    headed = all("heading" in run.channels and np.isfinite(run.channels["heading"]).sum() > 5 for run in runs)
    return [*names, "heading"] if headed else list(names)
