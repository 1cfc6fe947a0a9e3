"""The damping of the declared model, as the tracer fits it beside the effects."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline

from incsvr.tracing.run import Array

INTERVALS = 8
"""Of the cubic spline of d(r): 6 or 16 were worse on simulated vehicles."""

SPLINE = INTERVALS + 2
"""Its columns: of a cubic spline's INTERVALS + 3 the last is left out, for d(0) = 0."""


@dataclass(frozen=True, slots=True)
class Damping:
    """d(r) = Σ cⱼ (Bⱼ(r) − Bⱼ(0)) + c r|r|: a cubic B-spline that vanishes at rest, as Section III-A demands.

    Attributes:
        knots: of the spline [rad/s].
    """

    knots: Array

    @staticmethod
    def over(rate: Array) -> Damping:
        """A basis over the rates that occurred (rest included)."""
        low, high = (float(q) for q in np.quantile(rate, [0.001, 0.999]))
        low, high = min(low, -1e-3 * (high - low)), max(high, 1e-3 * (high - low))
        inner = np.linspace(low, high, INTERVALS + 1)
        return Damping(np.concatenate([[low] * 3, inner, [high] * 3]))

    def columns(self, rate: Array) -> Array:
        """(n, 11) basis at `rate` (n,); beyond the knots the spline stays and r|r| goes on."""
        low, high = self.knots[0], self.knots[-1]
        basis = BSpline.design_matrix(np.clip(rate, low, high), self.knots, 3).toarray()
        rest = BSpline.design_matrix(np.zeros(1), self.knots, 3).toarray()
        columns: Array = np.column_stack([(basis - rest)[:, :-1], rate * np.abs(rate)])
        return columns
