"""The vectors that a curve or a surface hangs on, and what is known of the noise in them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import pi, sqrt

import numpy as np

from incsvr.learning.excitation import Water
from incsvr.learning.kernel import rbf
from incsvr.learning.spread import Spread
from incsvr.numerics import Array, independent_part

SYSTEMATIC_NOISES = 0.3
"""Doubt that no number of samples takes away, in noise levels: between two samples torque and water are not known, and
the curve is as smooth as its kernel. On ordinary missions (seeds 2000 on) the weighted policy's band of 95 % holds the
truth in 94 % with it, and in 91 % with 0.2; in the paper's experiment, where the noise is the gyro's, in all."""
NOISE_SHARE = sqrt(1.0 - SYSTEMATIC_NOISES**2)
"""The noise as a part of what fresh samples leave over, which holds the systematic doubt as well."""
WATER_FACTOR = 1.5
"""Factor by which the water stands in what was learned beside what it would at random: motion counts as driven where
its work is clear, and the water may have helped it."""


@dataclass(frozen=True, eq=False)
class SupportSet:
    """The part of a model that answers need: the input of a table or a surface.

    Attributes:
        gamma: kernel width γ [(rad/s)⁻²].
        rate, damping, weight: (m,) the vectors [rad/s], [N m] and their θ [N m].
        count: (m,) how many samples each stands for.
        sigma: noise level of a damping sample [N m], over all rates.
        correlation: of the noise of two samples that follow each other.
        spread: how the noise follows the yaw rate.
        water: the motion that was no evidence, because the water made it.
        widening: by how much fresh samples have disagreed with the curve, in its own doubt; at least 1.
    """

    gamma: float
    rate: Array
    damping: Array
    weight: Array
    count: Array
    sigma: float
    correlation: float
    spread: Spread
    water: Water
    widening: float

    @cached_property
    def gram(self) -> Array:
        """(m, m) κ between the vectors."""
        return rbf(self.rate, self.rate, self.gamma)

    @cached_property
    def curve(self) -> Array:
        """(m,) f at the vectors [N m]."""
        return np.asarray(self.gram @ self.weight)

    @cached_property
    def noise(self) -> Array:
        """(m,) standard deviation of a sample at the vectors [N m]."""
        return np.asarray(self.sigma * self.spread.at(self.rate))

    @property
    def largest_damping(self) -> float:
        """The largest damping of the vectors [N m]; never zero."""
        return max(float(np.abs(self.damping).max()), 1e-9)

    @property
    def worth(self) -> float:
        """How many independent samples one of a vector is worth: noise that is correlated counts less, and the loss |e|
        of an SVR takes π/2 times as many as least squares."""
        return independent_part(self.correlation) * 2.0 / pi

    def sample_noise(self, rate: Array) -> Array:
        """(n,) standard deviation of the noise of a fresh sample at (n,) rates [N m]."""
        return np.asarray(NOISE_SHARE * self.sigma * self.spread.at(rate))

    def doubt(self, variance: Array, rate: Array) -> Array:
        """(n,) standard deviation of the answers at (n,) rates [N m], whose noise alone makes this variance [N² m²].

        Beside it stands what no number of samples takes away (SYSTEMATIC_NOISES), and what the water may have made of
        the slope; all of it as much wider as fresh samples have disagreed (disagreement.py).
        """
        systematic, water = SYSTEMATIC_NOISES * self.sigma, WATER_FACTOR * self.slope_by_water * rate
        return np.asarray(self.widening * np.sqrt(variance + systematic**2 + water**2))

    @property
    def slope_by_water(self) -> float:
        """The largest error of regression in the slope where the water moved the vehicle [N m s].

        The water makes motion of mean square s² with moments of deviation m, and what was learned moves by R²: it is
        m s/(s² + R²).
        """
        learned = float(self.count @ self.rate**2) / float(self.count.sum())
        return sqrt(self.water.moment * self.water.rate) / max(self.water.rate + learned, 1e-300)
