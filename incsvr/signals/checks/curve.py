"""What is learned of the damping, as far as the checks of one batch need it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from incsvr.samples import Array

STEP = 0.02
"""Over which the slope is taken, as a part of the learned range: well below the width of the kernel."""


@dataclass(frozen=True, slots=True)
class Curve:
    """The learned damping at the yaw rates of a batch of n samples.

    Attributes:
        damping: (n,) f(r) [N m].
        slope: (n,) f'(r) [N m s/rad].
        inside: (n,) whether a rate is within what was learned.
        sigma: noise level of a sample [N m].
        largest: the largest |f| that was learned [N m].
    """

    damping: Array
    slope: Array
    inside: NDArray[np.bool_]
    sigma: float
    largest: float

    @staticmethod
    def of(function: Callable[[Array], Array], rate: Array, known: tuple[float, float], sigma: float) -> Curve:
        """Of f, learned between the rates `known` [rad/s], at the rates (n,) of a batch."""
        low, high = known
        step = STEP * (high - low)
        ends = np.abs(function(np.array([low, high])))
        return Curve(
            function(rate),
            (function(rate + step) - function(rate - step)) / (2.0 * step),
            (rate >= low) & (rate <= high),
            sigma,
            float(ends.max()),
        )
