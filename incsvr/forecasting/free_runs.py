"""Free runs of a served model along a grid, with other velocities, a body and traced effects where there are any."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from incsvr.forecasting.damping_tables import Curve, CurveAmongOthers
from incsvr.forecasting.grid import Grid
from incsvr.forecasting.propagation import Runs, propagate
from incsvr.learning.model import Model
from incsvr.numerics import Array

if TYPE_CHECKING:
    from incsvr.forecasting.effects_ahead import EffectsAhead


def free_runs(
    model: Model,
    inertia: float,
    fastest: float,
    grid: Grid,
    rows: NDArray[np.intp],
    rate: Array,
    rate_sigma: float,
    effects: EffectsAhead | None = None,
) -> Runs:
    """n runs side by side.

    Args:
        model: trained.
        inertia: as it is declared [kg m²].
        fastest: the fastest rate of the vehicle [rad/s].
        grid: without a pause; it holds the model's further velocities.
        rows: (steps + 1, n) the points of the grid along each run.
        rate: (n,) where they start [rad/s].
        rate_sigma: how well that is known [rad/s].
        effects: on this grid; None for none.
    """
    beside = grid.beside
    linear = None if beside.linear is None else beside.linear[rows]
    whole = inertia if effects is None else inertia + effects.added_inertia
    curve: Curve | CurveAmongOthers
    if model.several is None:
        curve = Curve.of(model, whole, fastest, grid.sample_period, linear)
    else:
        others = np.column_stack([beside.channels[name] for name in model.several.others])
        curve = CurveAmongOthers.of(model, others, rows, grid.step, whole, fastest, grid.sample_period, linear)
    torque = grid.torque[rows] if effects is None else np.zeros(rows.shape)
    if beside.outside is not None:
        torque = torque - beside.outside[rows]
    return propagate(curve, rate, rate_sigma, torque, grid.step, None if effects is None else effects.runs(rows[0]))
