"""Whether the errors of a vehicle's predictions look like those of velocities over ground in a steady current.

Through the water the velocity is ν − R(η)ᵀ c, with c the current. One Newton step of all parameters together with c, at
c = 0, says how large it would be, with standard errors over blocks.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc

from incsvr.model.fitting import Fit, equations
from incsvr.model.left_out import blocks
from incsvr.model.simulation import predict
from incsvr.model.tangent import tangent
from incsvr.model.windows import cut
from incsvr.numerics import Array, Streams

CURRENT_STEP_M_S = 0.02
"""The current whose effect on the errors gives their slope [m/s]: a tenth of one that matters."""
MAX_FALSE_CURRENT_CHANCE = 1e-4
"""The chance that errors without a current look like a current as clear, below which the current is named."""


@dataclass(frozen=True, slots=True)
class Current:
    """A steady current that would explain errors of prediction.

    Attributes:
        north, east: its velocity [m/s].
        p_value: of none.
    """

    north: float
    east: float
    p_value: float

    @property
    def warning(self) -> str:
        """A sentence on it, with the cure."""
        speed, towards = np.hypot(self.north, self.east), np.degrees(np.arctan2(self.east, self.north)) % 360.0
        return (
            f"the errors of prediction look like those of a steady current of {speed:.2g} m/s towards {towards:.0f}°, "
            "in which inertias and damping are wrong by more than their intervals: record in still "
            "water, or the velocity through the water"
        )


def suspected_current(found: Fit) -> Current | None:
    """The current that a fit's errors look like; None where they do not, or surge, sway or heading are not recorded."""
    problem, windows = found.problem, found.problem.windows
    if not {"surge", "sway"} <= set(windows.axes) or not all("heading" in run for run in windows.runs):
        return None
    point = np.array([found.theta[name] for name in found.names])
    own, p = tangent(found.course, point, found.units), point.size
    columns = [_slope(found, point, *each) for each in ((1.0, 0.0), (0.0, 1.0))]
    by = np.column_stack([own[:, :p], *columns, own[:, p:]])
    both = equations(problem.white(by), problem, found.error, found.starts, found.scale)
    inverse = np.linalg.pinv(both.normal.sum(axis=0) + np.diag(np.r_[found.prior, 0.0, 0.0]), rcond=1e-12)
    step = (inverse @ both.gradient.sum(axis=0))[-2:]
    block = blocks(windows)
    moved = np.stack([np.bincount(block, each) for each in both.gradient.T], axis=1) @ inverse[:, -2:]
    # The errors of blocks scatter by chance; what windows that err alike would give keeps them from being too small.
    covariance = moved.T @ moved + inverse[-2:, -2:]
    p_value = float(chdtrc(2, step @ np.linalg.solve(covariance, step)))
    return Current(float(step[0]), float(step[1]), p_value) if p_value < MAX_FALSE_CURRENT_CHANCE else None


def _slope(found: Fit, point: Array, north: float, east: float) -> Array:
    """(samples,) by how much the predictions, less what was measured, change with a current along a direction."""
    before, structure, apart = found.problem.windows, found.structure, []
    for side in (-1.0, 1.0):
        current = side * CURRENT_STEP_M_S * np.array([north, east, 0.0])
        runs = [_through_water(run, current) for run in before.runs]
        windows = cut(runs, structure, before.step, before.step * before.steps)
        starts = found.starts + windows.starts - before.starts
        apart.append(predict(structure, point[:, None], windows, starts[:, None])[:, 0] - windows.measured)
    return np.asarray((apart[1] - apart[0]) / (2.0 * CURRENT_STEP_M_S))


def _through_water(run: Streams, current: Array) -> Streams:
    """A recording with velocities through the water, which moves with a current (3,) of north, east and down [m/s]."""
    found = dict(run)
    for k, name in enumerate(("surge", "sway", "heave")):
        if name not in run:
            continue
        time, values = run[name]
        roll, pitch, heading = (
            np.interp(time, run[angle][0], np.unwrap(run[angle][1])) if angle in run else np.zeros_like(time)
            for angle in ("roll", "pitch", "heading")
        )
        (cr, cp, cy), (sr, sp, sy) = np.cos([roll, pitch, heading]), np.sin([roll, pitch, heading])
        along = (
            (cy * cp, sy * cp, -sp),
            (cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr),
            (cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr),
        )[k]
        found[name] = (time, values - sum(part * each for part, each in zip(along, current.tolist(), strict=True)))
    return found
