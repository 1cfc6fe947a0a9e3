"""A gyro's zero."""

from __future__ import annotations

import numpy as np

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Signals
from incsvr.numerics import Array

SLOPE_RATE_SHARE = 0.05
"""Part of the fastest turn over which the damping's slope is taken."""

MAX_ZERO_SHARE = 0.3
"""Part of the fastest turn that a gyro's zero is at most: one beyond is a fault that nobody overlooks."""


class GyroBias(Effect):
    """The gyro shows r + b, so that I ṙ + d(r_m − b) = τ: to first order d′(r) b is missing from the damping.

    Where d is linear that is a constant moment, and only a heading tells the two apart. All free runs are of the
    measured rate, in which the zero stays.
    """

    name = "gyro_bias"
    sentence = "the gyro's zero is off: it shows a constant rate where the vehicle does not turn, and no {moment} acts"
    source = "J. A. Farrell, Aided Navigation, 2008, ch. 11 (gyro bias)"
    equation = "I ṙ + d(r − b) = τ"
    shown_by = "fast and slow motion, and a measured heading: without one it looks like a constant {moment}"
    acts = "motion"
    parameter_names = ("rate_rad_s",)

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        """A rate small beside the fastest turn [rad/s], to either side of which the damping's slope is taken."""
        return [(SLOPE_RATE_SHARE * float(np.quantile(np.abs(s.rate), 0.99)),)]

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        beside = max(inner[0], 1e-9)
        return stack((s.drag_at(s.rate - beside) - s.drag_at(s.rate + beside)) / (2.0 * beside))

    def implausible(self, term: Term, s: Signals) -> str:
        part = abs(term.coefficients[0]) / float(np.quantile(np.abs(s.rate), 0.99))
        return f"the zero would be off by {part:.0%} of the fastest turn" if part > MAX_ZERO_SHARE else ""
