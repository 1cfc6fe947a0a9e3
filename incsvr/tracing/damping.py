"""The damping beside the effects: quadratic drag, and a line whose slope changes with the rate; d(0) = 0.

    d(r) = b₊ max(r, 0)² − b₋ min(r, 0)² + ∫₀ʳ s(x) dx,    s constant between the knots

Slopes and quadratic drags that differ from their neighbours, or from the other side, cost a ridge, so that the curve
bends only where the data ask for it. No coefficient is negative: damping never drives a turn.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from incsvr.model_trace.thresholds import KNOT_RATE_SHARES, SLOPE_PRIOR_DEVIATION
from incsvr.numerics import Array


@dataclass(frozen=True, slots=True)
class DampingBasis:
    """The functions of which d(r) consists: the two quadratic ones, the inner line, then ramps to either side.

    Attributes:
        fastest: usual largest rate [rad/s], in parts of which the knots stand.
        torque: usual largest torque [N m]; with `fastest` it says what is a large slope.
    """

    fastest: float
    torque: float

    @property
    def size(self) -> int:
        """Number of the functions."""
        return 3 + 2 * len(KNOT_RATE_SHARES)

    def columns(self, rate: Array) -> Array:
        """(size, …) the functions at `rate` (…)."""
        knots = [part * self.fastest for part in KNOT_RATE_SHARES]
        rows = [np.maximum(rate, 0.0) ** 2, -(np.minimum(rate, 0.0) ** 2), np.clip(rate, -knots[0], knots[0])]
        for begin, end in zip(knots, [*knots[1:], np.inf], strict=True):
            rows += [np.clip(rate - begin, 0.0, end - begin), np.clip(rate + begin, begin - end, 0.0)]
        return np.stack(rows)

    def start(self) -> Array:
        """(size,) coefficients from which a fit begins: linear and quadratic drag that take most of the torque."""
        slope = 0.4 * self.torque / self.fastest
        return np.array([slope / self.fastest] * 2 + [slope] * (self.size - 2))

    @property
    def precision(self) -> Array:
        """(size, size) of the prior: neighbouring slopes are alike, and so are the two quadratic drags."""
        unit = np.eye(self.size)
        rows = [(unit[0] - unit[1]) * self.fastest]
        for side in (0, 1):
            chain = [2, *range(3 + side, self.size, 2)]
            rows += [unit[after] - unit[before] for before, after in pairwise(chain)]
        differences = np.array(rows) / (SLOPE_PRIOR_DEVIATION * self.torque / self.fastest)
        return np.asarray(differences.T @ differences)
