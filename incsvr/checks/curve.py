"""The learned damping, as far as the checks of one batch need it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array

SLOPE_STEP_SHARE = 0.02
"""Step over which the slope is taken, as a share of the learned range: well below the width of the kernel."""


class ServedCurve(NamedTuple):
    """The values of a model at (n,) yaw rates.

    Attributes:
        damping: (n,) f(r) [N m].
        doubt: (n,) standard deviation of the curve itself [N m].
        learned: (n,) whether anything was learned there: a range has gaps.
    """

    damping: Array
    doubt: Array
    learned: NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Curve:
    """The learned damping at the yaw rates of a batch of n samples.

    Attributes:
        damping: (n,) f(r) [N m].
        slope: (n,) f'(r) [N m s/rad].
        inside: (n,) whether anything was learned at a rate.
        doubt: (n,) standard deviation of the curve itself [N m].
        sigma: noise level of a sample, with what the water adds to it [N m].
        largest: the largest |f| that was learned [N m].
    """

    damping: Array
    slope: Array
    inside: NDArray[np.bool_]
    doubt: Array
    sigma: float
    largest: float

    @staticmethod
    def of(function: Callable[[Array], ServedCurve], rate: Array, known: tuple[float, float], sigma: float) -> Curve:
        """The curve of f, learned between the rates `known` [rad/s], at the rates (n,) of a batch."""
        low, high = known
        step, n = SLOPE_STEP_SHARE * (high - low), rate.size
        at = function(np.concatenate((rate, rate - step, rate + step, known)))
        return Curve(
            at.damping[:n],
            (at.damping[2 * n : 3 * n] - at.damping[n : 2 * n]) / (2.0 * step),
            at.learned[:n],
            at.doubt[:n],
            sigma,
            float(np.abs(at.damping[3 * n :]).max()),
        )
