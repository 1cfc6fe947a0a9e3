"""Whether the errors of a vehicle's predictions look like those of velocities over ground in a steady current.

Through the water the velocity is ν − R(η)ᵀ c, with c the current. One Newton step of all parameters together with c, at
c = 0, says how large it would be, with the standard errors of the jackknife.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2

from incsvr.numerics import Array
from incsvr.vehicle.fitting import Fit, Windows, normal_equations
from incsvr.vehicle.intervals import Scatter
from incsvr.vehicle.motion import WholeMotion

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


def suspected_current(windows: Windows, fitted: Fit) -> Current | None:
    """The current that a fit's errors look like; None where they do not, or surge, sway or heading are not recorded."""
    if not {"surge", "sway", "heading"} <= windows.motion.recorded:
        return None
    columns = [_slope(windows, fitted, north, east) for north, east in ((1.0, 0.0), (0.0, 1.0))]
    slope = np.concatenate([fitted.slope, np.stack(columns)])
    scale = np.concatenate([fitted.scale, np.ones(2)])
    both = replace(fitted, slope=slope, scale=scale, parameters=np.concatenate([fitted.parameters, np.zeros(2)]))
    scatter = Scatter.of(both)
    _, gradient = normal_equations(slope, fitted.error, fitted.weight)
    step = (-scatter.inverse @ gradient)[-2:]
    moved = scatter.moved[:, -2:]
    # The errors of blocks scatter by chance; what windows that err alike would give keeps them from being too small.
    covariance = moved.T @ moved * (1.0 - 1.0 / moved.shape[0]) + scatter.inverse[-2:, -2:]
    p_value = float(chi2.sf(step @ np.linalg.solve(covariance, step), 2))
    return Current(float(step[0]), float(step[1]), p_value) if p_value < MAX_FALSE_CURRENT_CHANCE else None


def _slope(windows: Windows, fitted: Fit, north: float, east: float) -> Array:
    """∂error/∂current along a direction, (windows, cells, axes)."""
    current, found = CURRENT_STEP_M_S * np.array([north, east, 0.0]), []
    for side in (-1.0, 1.0):
        moved = replace(windows, motion=_through_water(windows.motion, side * current))
        found.append(moved.errors(fitted.structure, fitted.parameters[None])[0])
    return np.asarray((found[1] - found[0]) / (2.0 * CURRENT_STEP_M_S))


def _through_water(motion: WholeMotion, current: Array) -> WholeMotion:
    """The motion with velocities through the water, which moves with a current (3,) of north, east and down [m/s]."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(motion.angle).T, np.sin(motion.angle).T
    rotation = np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )
    velocity = motion.velocity.copy()
    recorded = [name in motion.recorded for name in ("surge", "sway", "heave")]
    velocity[:, :3] -= np.einsum("ijn,i->nj", rotation, current) * recorded
    return replace(motion, velocity=velocity)
