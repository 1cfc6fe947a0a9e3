"""The noise of a damping sample as a function of the yaw rate.

Rotors shake a gyro the more the faster they turn, and the water is rough where a vehicle is fast. So beside the level
of the noise its variance is tracked at five rates, as shares of that level, straight between them and alike to both
sides. What nobody has seen yet is as loud as the level says.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from incsvr.numerics import Array

KNOT_COUNT = 5
"""Number of rates at which the variance is known, evenly from rest to the fastest."""
PRIOR_SAMPLES = 10.0
"""Samples for which "as loud as the level says" stands at each of them."""
HORIZON_SAMPLES = 100.0
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

    @staticmethod
    def start(rate_range: tuple[float, float]) -> Spread:
        """Before the first sample, for a vehicle of this range [rad/s]."""
        return Spread(max(abs(end) for end in rate_range))

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
        seen = np.minimum(np.array(self.seen), np.maximum(HORIZON_SAMPLES - new, 0.0))
        variance = (seen * np.array(self.variance) + total) / np.maximum(seen + new, 1e-12)
        return Spread(self.fastest, tuple(variance.tolist()), tuple((seen + new).tolist()))
