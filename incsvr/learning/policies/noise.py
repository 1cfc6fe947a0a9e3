"""The noise of the damping samples, tracked from what the curve leaves over."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, log

import numpy as np
from numpy.typing import NDArray

from incsvr.learning.criteria import quartiles
from incsvr.learning.spread import Spread
from incsvr.numerics import MAX_CORRELATION, Array, independent_part
from incsvr.numerics.deviation import NORMAL_DEVIATION_PER_MEDIAN

HORIZON_SAMPLES = 250.0
"""Samples that the running means stand for, at most."""
MIN_NOISE_NM = 1e-6
"""Least noise level that is believed [N m]: data without noise must not divide by zero."""


@dataclass(frozen=True, slots=True)
class Noise:
    """Level and colour of the noise: running means over batches.

    The level is the mean of the logarithm of each batch's robust variance. So outliers do not move it, and after ten
    quiet batches nobody remembers a loud one, which would dominate a mean of variances.
    """

    spread: Spread  # how the noise follows the yaw rate
    variance: float = 1.0  # σ² of a sample about the curve [N² m²]
    correlation: float = 0.0  # ρ of two samples that follow each other, in [0, 0.95]
    seen: float = 0.0  # samples that the means stand for; 0 before the first batch

    @staticmethod
    def start(rate_range: tuple[float, float]) -> Noise:
        """Before the first batch, for a vehicle of this range [rad/s]."""
        return Noise(Spread.start(rate_range))

    @property
    def sigma(self) -> float:
        """σ [N m]; NaN before the first batch."""
        return float(np.sqrt(self.variance)) if self.seen else float("nan")

    @property
    def worth(self) -> float:
        """The number of independent samples per sample in a mean: (1 − ρ)/(1 + ρ)."""
        return independent_part(self.correlation)

    def after(self, residual: Array, index: NDArray[np.intp], rate: Array) -> Noise:
        """The noise after a batch.

        Args:
            residual: (n,) y − f(x) [N m], n ≥ 1.
            index: (n,) place of each in the stream, increasing; only neighbours tell of the correlation.
            rate: (n,) yaw rate of each [rad/s].
        """
        n = residual.size
        level = max(NORMAL_DEVIATION_PER_MEDIAN * quartiles(np.abs(residual))[1], MIN_NOISE_NM)
        power = float(residual @ residual) / n
        neighbours = index[1:] - index[:-1] == 1
        pairs = int(np.count_nonzero(neighbours))
        product = float((residual[1:] * residual[:-1]) @ neighbours)
        colour = product / pairs / power if pairs and power > 0.0 else 0.0
        seen = min(self.seen, HORIZON_SAMPLES - n) if n < HORIZON_SAMPLES else 0.0
        share = n / (seen + n)
        variance = exp((1.0 - share) * log(self.variance) + share * 2.0 * log(level))
        correlation = (1.0 - share) * self.correlation + share * colour
        spread = self.spread.after(rate, residual, variance**0.5)
        return Noise(spread, variance, min(max(correlation, 0.0), MAX_CORRELATION), seen + n)
