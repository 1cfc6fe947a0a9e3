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

    @property
    def slope_by_water(self) -> float:
        """The largest error of regression in the slope where the water moved the vehicle [N m s].

        The water makes motion of mean square s² with moments of deviation m, and what was learned moves by R²: it is
        m s/(s² + R²).
        """
        learned = float(self.count @ self.rate**2) / float(self.count.sum())
        return sqrt(self.water.moment * self.water.rate) / max(self.water.rate + learned, 1e-300)
