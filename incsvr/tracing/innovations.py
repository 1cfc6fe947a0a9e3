"""Innovations: errors one cell ahead, exact where a controller closes the loop with commands.

A cell is the time between two commands, so that nothing in it answers what happens in it; everything on the right of
the equation is known at its beginning, and a controller that answers the rate does no harm (U. Forssell, L. Ljung,
Automatica 35, 1999).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.model_trace.run import Run, sample_period
from incsvr.model_trace.thresholds import (
    ALIKE_PERIOD_RANGE,
    MAX_INNOVATIONS,
    MAX_SUBSTEPS,
    OFFSET_PRIOR_PERIODS,
    START_REFLECTIONS,
    STRETCH_SCALES,
    SUBSTEP_SETTLINGS,
)
from incsvr.model_trace.torque_nature import TorqueNature
from incsvr.tracing.cells import Cut, cut, settling_time, time_scale
from incsvr.tracing.dynamics import Windows
from incsvr.tracing.errors import Colour, Problem, pieces_of
from incsvr.tracing.windows import hypothesis_of_nothing


def cutting(runs: Sequence[Run], inertia: float, nature: TorqueNature) -> Cut:
    """Cells between two commands, cut once more where the vehicle settles far in one."""
    period, commands = sample_period(runs, "yaw_rate"), sample_period(runs, "torque")
    by_command = ALIKE_PERIOD_RANGE[0] < commands / period < ALIKE_PERIOD_RANGE[1]
    step, scale = commands if by_command else period, time_scale(runs)
    divide = int(np.clip(np.ceil(step / (SUBSTEP_SETTLINGS * settling_time(runs, inertia))), 1, MAX_SUBSTEPS))
    return Cut(step, nature, scale, "torque" if by_command else "yaw_rate", divide)


def pose(
    runs: Sequence[Run], inertia: float, names: Sequence[str], nature: TorqueNature, thinned: bool = True
) -> Problem:
    """The recordings as cells that are predicted one by one, each from the rate at its beginning.

    Args:
        thinned: whether of long recordings stretches are taken.

    Raises:
        BadInput: yaw rate and torque never overlap in time.
    """
    how = cutting(runs, inertia, nature)
    cells = cut(runs, inertia, names, how)
    slices: Sequence[slice] = pieces_of(cells)
    total = len(cells) // how.divide
    if thinned and total > MAX_INNOVATIONS:
        length = max(round(STRETCH_SCALES * how.scale / how.step), 1) * how.divide
        slices = _spread(slices, length, MAX_INNOVATIONS / total)
    windows = Windows.tiled(slices, how.divide)
    starts = np.cumsum([0, *((s.stop - s.start) // how.divide for s in slices)])
    colour = Colour(tuple(starts.tolist()), float(np.exp(-how.step / how.scale)), START_REFLECTIONS)
    ahead = Windows.tiled(pieces_of(cells), max(round(how.scale / cells.step), how.divide))
    share = windows.first.size / total if thinned and total > MAX_INNOVATIONS else 1.0
    return Problem(
        cells,
        windows,
        0.5 * OFFSET_PRIOR_PERIODS * cells.torque_period,
        hypothesis_of_nothing(cells),
        colour,
        ahead,
        share,
    )


def _spread(slices: Sequence[slice], length: int, share: float) -> list[slice]:
    """Stretches of so many cells, spread evenly, that hold this share of the slices."""
    stretches = [slice(a, min(a + length, s.stop)) for s in slices for a in range(s.start, s.stop, length)]
    kept = np.linspace(0, len(stretches) - 1, max(int(len(stretches) * share), 1)).astype(int)
    return [stretches[k] for k in np.unique(kept)]
