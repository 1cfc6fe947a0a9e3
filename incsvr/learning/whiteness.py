"""Whether a learner's residual is still white: a score test, cheap enough for every batch.

The residual of a model that lacks nothing is white but for what its curve over the rate still has to learn. So a curve
over the rate that vanishes at rest, as damping does, is taken out first, and the rest is asked whether it follows a
constant moment, the time, or its own past (T. S. Breusch, Australian Economic Papers 17, 1978; L. G. Godfrey,
Econometrica 46, 1978): n R² of that regression is χ² where it does not.

It says that something is missing, not what. Water that pushes the vehicle for longer than a sample makes a residual
coloured, too: a tracer has to look.
"""

from __future__ import annotations

import numpy as np
from scipy.special import chdtrc

from incsvr.samples import Array

LAGS = 5
"""How far back a residual is asked about its own past [samples]."""
INTERVALS = 8
"""Of the curve over the rate, between the slowest and the fastest turn."""
FEWEST = 100
"""Samples below which the test says nothing."""
_OUTLIER = 4.0  # in deviations, drawn in: the learner throws outliers out


def p_value(time: Array, yaw_rate: Array, residual: Array, period: float) -> float:
    """The chance of a residual as coloured as this if it were white; 1 where there are too few samples.

    Args:
        time: (n,) stamps [s], multiples of `period`, increasing; they may pause.
        yaw_rate: (n,) [rad/s].
        residual: (n,) measured minus served damping, the served one moved so that it vanishes at rest [N m].
        period: between two samples [s], far enough apart for the smoothing to have left them independent.
    """
    if time.size < FEWEST or not np.ptp(yaw_rate) > 0.0:
        return 1.0
    curve = _curve(yaw_rate)
    left = residual - curve @ np.linalg.lstsq(curve, residual, rcond=None)[0]
    middle = float(np.median(left))
    limit = _OUTLIER * 1.4826 * float(np.median(np.abs(left - middle)))
    left = np.clip(left, middle - limit, middle + limit)
    if not np.ptp(left) > 0.0:
        return 1.0
    age = (time - time.mean()) / np.ptp(time)
    asked = np.column_stack([np.ones(time.size), age, _past(time, left, period)])
    # Both sides without the curve, so that what is asked takes nothing that the curve could have taken.
    sides = np.column_stack([left, asked])
    sides = sides - curve @ np.linalg.lstsq(curve, sides, rcond=None)[0]
    left, asked = sides[:, 0], sides[:, 1:]
    fitted = asked @ np.linalg.lstsq(asked, left, rcond=None)[0]
    return float(chdtrc(asked.shape[1], time.size * float(fitted @ fitted) / float(left @ left)))


def _curve(rate: Array) -> Array:
    """(n, INTERVALS) hat functions of the rate, each without its value at rest."""
    knots = np.linspace(min(float(rate.min()), 0.0), max(float(rate.max()), 0.0), INTERVALS + 1)
    hats = [np.interp(rate, knots, row) - np.interp(0.0, knots, row) for row in np.eye(knots.size)]
    return np.column_stack(hats)[:, np.ptp(hats, axis=1) > 0.0]


def _past(time: Array, values: Array, period: float) -> Array:
    """(n, LAGS) the values 1, 2, … periods earlier, their mean where there is none."""
    index = np.rint(time / period).astype(np.int64)
    centred = values - values.mean()
    past = np.zeros((time.size, LAGS))
    for lag in range(1, LAGS + 1):
        at = np.minimum(np.searchsorted(index, index - lag), index.size - 1)
        there = index[at] == index - lag
        past[there, lag - 1] = centred[at[there]]
    return past
