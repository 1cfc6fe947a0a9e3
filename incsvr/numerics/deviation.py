"""Sizes of errors: the root of their mean square, and a deviation that a few gross ones do not change."""

from __future__ import annotations

import numpy as np

from incsvr.numerics.arrays import Array

NORMAL_DEVIATION_PER_MEDIAN = 1.4826
"""Standard deviation of normal numbers over the median of their sizes, 1/Φ⁻¹(3/4)."""


def robust_deviation(values: Array) -> float:
    """The standard deviation of (n,) numbers about zero if all but less than half of them are normal.

    It is 1.4826 times the median of their sizes (F. R. Hampel, JASA 69, 1974); NaN of no number.
    """
    return NORMAL_DEVIATION_PER_MEDIAN * float(np.median(np.abs(values)))


def root_mean_square(values: Array) -> float:
    """√(mean of the squares) of (n,) numbers; NaN of no number."""
    return float(np.sqrt(np.mean(values**2)))
