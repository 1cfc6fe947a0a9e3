"""The noise of the damping samples, tracked from what the curve leaves over: its level, colour and spread.

Rotors shake a gyro the more the faster they turn, and the water is rough where a vehicle is fast. So beside the level
of the noise its variance is tracked at five rates, as shares of that level, straight between them and alike to both
sides. What nobody has seen yet is as loud as the level says.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, log

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import MAX_CORRELATION, Array, independent_part
from incsvr.numerics.deviation import NORMAL_DEVIATION_PER_MEDIAN

Mask = NDArray[np.bool_]
HORIZON_SAMPLES = 250.0
"""Samples that the running means of level and colour stand for, at most."""
MIN_NOISE_NM = 1e-6
"""Least noise level that is believed [N m]: data without noise must not divide by zero."""
KNOT_COUNT = 5
"""Number of rates at which the variance is known, evenly from rest to the fastest."""
PRIOR_SAMPLES = 10.0
"""Samples for which "as loud as the level says" stands at each of them."""
KNOT_HORIZON_SAMPLES = 100.0
"""Samples that each knot stands for, at most: some ten batches."""
MAX_SAMPLE_DEVIATIONS = 2.5
"""Deviations that a sample counts for, at most: an outlier must not be the noise."""
_KNOTS = np.arange(float(KNOT_COUNT))
_CLIPPED_VARIANCE = 0.97750
"""Mean square of a normal deviate that is clipped at MAX_SAMPLE_DEVIATIONS."""


@dataclass(frozen=True, slots=True)
class Spread:
    """The noise's variance over the level's, by rate."""

    fastest: float  # the vehicle's largest |r| [rad/s]
    # (KNOT_COUNT,) at |r| from 0 to the fastest, as shares of the level's
    variance: tuple[float, ...] = (1.0,) * KNOT_COUNT
    seen: tuple[float, ...] = (PRIOR_SAMPLES,) * KNOT_COUNT  # (KNOT_COUNT,) samples that each stands for

    @property
    def possible(self) -> bool:
        """Whether every number is one that learning can have led to."""
        parts = np.array((self.variance, self.seen))
        return (
            parts.shape == (2, KNOT_COUNT)
            and bool(np.isfinite(parts).all() and parts.min() >= 0.0)
            and self.fastest > 0.0
        )

    def at(self, rate: Array) -> Array:
        """(n,) standard deviation over the level's, at (n,) rates [rad/s]."""
        return np.asarray(np.sqrt(np.interp(np.abs(rate) * ((KNOT_COUNT - 1) / self.fastest), _KNOTS, self.variance)))

    def after(self, rate: Array, residual: Array, level: float) -> Spread:
        """The spread after n ≥ 1 further samples.

        Args:
            rate: (n,) [rad/s].
            residual: (n,) what the curve leaves over [N m].
            level: the noise's standard deviation [N m], above 0.
        """
        place = np.minimum(np.abs(rate) / self.fastest, 1.0) * (KNOT_COUNT - 1)
        near = np.maximum(1.0 - np.abs(place - _KNOTS[:, None]), 0.0)
        square = np.minimum((residual / level) ** 2, (MAX_SAMPLE_DEVIATIONS * self.at(rate)) ** 2) / _CLIPPED_VARIANCE
        new, total = near.sum(axis=1), near @ square
        seen = np.minimum(np.array(self.seen), np.maximum(KNOT_HORIZON_SAMPLES - new, 0.0))
        variance = (seen * np.array(self.variance) + total) / np.maximum(seen + new, 1e-12)
        return Spread(self.fastest, tuple(variance.tolist()), tuple((seen + new).tolist()))


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
        return Noise(Spread(max(abs(end) for end in rate_range)))

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


def quartiles(values: Array) -> tuple[float, float, float]:
    """First quartile, median and third quartile of (n,) values, n ≥ 1, interpolated linearly.

    The same figures as `np.percentile(values, (25, 50, 75))` at a twentieth of its cost.
    """
    ordered = np.sort(values).tolist()
    last = len(ordered) - 1

    def at(share: float) -> float:
        place = share * last
        below = int(place)
        lower, upper = ordered[below], ordered[min(below + 1, last)]
        return float(lower + (place - below) * (upper - lower))

    return at(0.25), at(0.5), at(0.75)


def outliers(residual: Array, *, whiskers: float = 1.5) -> Mask:
    """Outliers (Section III-C 3): (n,) mask of the residuals outside [Q1 − 1.5 IQR, Q3 + 1.5 IQR]."""
    if residual.size == 0:
        return np.zeros(0, dtype=bool)
    first, _, third = quartiles(residual)
    reach = whiskers * (third - first)
    return (residual < first - reach) | (residual > third + reach)
