"""The damping beside the effects: a natural cubic spline with d(0) = 0, and r|r|, whose bend at rest a spline
rounds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from incsvr.tracing.forward.thresholds import KNOTS

Array = NDArray[np.float64]

TABLE = 2001
"""Values of each function: a line between two errs by 1e-5 of the largest."""


@dataclass(frozen=True, slots=True)
class DampingBasis:
    """d(r) = Σ cⱼ (Bⱼ(r) − Bⱼ(0)) + c r|r|, as Section III-A demands d(0) = 0; beyond the knots the spline is a line.

    Attributes:
        knots: (KNOTS,) of the spline [rad/s].
        reach: the table's ends are ± this [rad/s].
        table: (KNOTS − 1, TABLE) the spline's functions in even steps between them.
    """

    knots: Array
    reach: float
    table: Array

    @staticmethod
    def over(rate: Array) -> DampingBasis:
        """A basis over the rates that occurred, rest included."""
        low, high = (float(q) for q in np.quantile(rate, [0.002, 0.998]))
        span = max(high - low, 1e-9)
        knots = np.linspace(min(low, -0.05 * span), max(high, 0.05 * span), KNOTS)
        reach = 2.0 * max(float(np.max(np.abs(rate))), float(np.max(np.abs(knots))))
        at = np.linspace(-reach, reach, TABLE)
        spline = CubicSpline(knots, np.eye(KNOTS), bc_type="natural")
        inside = np.clip(at, knots[0], knots[-1])
        slopes = np.where(at[:, None] < knots[0], spline(knots[0], 1), spline(knots[-1], 1))
        values = spline(inside) - spline(0.0) + (at - inside)[:, None] * slopes
        # with their values at rest taken off, the cardinal splines sum to zero: the one nearest to rest is left out
        table = np.delete(values, int(np.argmin(np.abs(knots))), axis=1).T
        return DampingBasis(knots, reach, np.ascontiguousarray(table))

    @property
    def size(self) -> int:
        """Number of its functions."""
        return self.knots.size

    def columns(self, rate: Array) -> Array:
        """(KNOTS, n) the basis at `rate` (n,); beyond the reach the spline's part stays."""
        place = np.clip((rate + self.reach) * ((TABLE - 1) / (2.0 * self.reach)), 0.0, TABLE - 1.0)
        cell = np.minimum(place.astype(np.intp), TABLE - 2)
        part = place - cell
        out = np.empty((self.size, rate.size))
        for row, values in zip(out, self.table, strict=False):
            low = values[cell]
            row[:] = low + part * (values[cell + 1] - low)
        out[-1] = rate * np.abs(rate)
        return out
