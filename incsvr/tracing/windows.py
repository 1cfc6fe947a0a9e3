"""Windows of a time scale: errors of prediction where nothing answers the water, in open loop."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.model_trace.run import Run, sample_period
from incsvr.model_trace.thresholds import (
    CELLS_PER_SETTLING,
    MAX_WINDOW_CELLS,
    MAX_WINDOWS,
    MIN_WINDOW_CELLS,
    MIN_WINDOW_SETTLINGS,
    MIN_WINDOWS,
    OFFSET_PRIOR_PERIODS,
    USUAL_QUANTILES,
)
from incsvr.model_trace.torque_nature import TorqueNature
from incsvr.tracing.cells import Cells, Cut, cut, settling_time, time_scale
from incsvr.tracing.damping import DampingBasis
from incsvr.tracing.dynamics import Windows
from incsvr.tracing.errors import Colour, Problem, pieces_of
from incsvr.tracing.hypothesis import Hypothesis


def cutting(runs: Sequence[Run], inertia: float, nature: TorqueNature) -> Cut:
    """Cells that follow the vehicle, at least a period of the gyro long, and windows of a whole number of them."""
    scale, period = time_scale(runs), sample_period(runs, "yaw_rate")
    settling = min(settling_time(runs, inertia), scale)
    duration = sum(float(run.time[-1] - run.time[0]) for run in runs)
    length = min(scale, max(duration / MIN_WINDOWS, MIN_WINDOW_SETTLINGS * settling))
    steps = int(np.clip(round(length / max(settling / CELLS_PER_SETTLING, period)), MIN_WINDOW_CELLS, MAX_WINDOW_CELLS))
    return Cut(max(length / steps, period), nature, scale, steps=steps)


def pose(runs: Sequence[Run], inertia: float, names: Sequence[str], nature: TorqueNature) -> Problem:
    """The recordings as windows, one after the other, that are predicted from the rate at their beginning.

    Raises:
        BadInput: yaw rate and torque never overlap in time.
    """
    how = cutting(runs, inertia, nature)
    cells = cut(runs, inertia, names, how)
    windows = Windows.tiled(pieces_of(cells), how.steps)
    count = windows.first.size
    if count > MAX_WINDOWS:
        windows = windows.take(np.unique(np.linspace(0, count - 1, MAX_WINDOWS).astype(np.intp)))
    share = windows.first.size / max(count, 1)
    return Problem(
        cells, windows, OFFSET_PRIOR_PERIODS * cells.resolution, hypothesis_of_nothing(cells), Colour(), share=share
    )


def hypothesis_of_nothing(cells: Cells) -> Hypothesis:
    """The hypothesis of no effect, from which fits begin."""
    s = cells.signals
    fastest = max(float(np.quantile(np.abs(s.rate), USUAL_QUANTILES[1])), 1e-9)
    largest = float(np.quantile(np.abs(s.torque), USUAL_QUANTILES[1])) or s.inertia * fastest / s.scale
    basis = DampingBasis(fastest, largest)
    return Hypothesis(basis, basis.start(), 0.0, (), cells.resolution)
