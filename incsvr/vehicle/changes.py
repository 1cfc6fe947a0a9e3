"""A test of change that holds its level over any number of dives, for many quantities of many vehicles at once.

Dive k is compared with the weighted mean of the dives since the last change. It may spend LEVEL/(k (k + 1)), divided
among the quantities of a vehicle, so that any number of dives of it spends LEVEL together (the union bound; the dives
need not be independent).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtr, stdtrit

from incsvr.numerics import Array

LEVEL = 0.05
"""Chance of any false change over all dives and quantities of a vehicle."""


@dataclass(frozen=True, slots=True)
class Changes:
    """What the test says of each quantity in each dive.

    Attributes:
        reference: (quantities, dives) mean of the dives since the last change; no number in the first of them.
        reference_error: (quantities, dives) its standard error.
        p_value: (quantities, dives) of no change against that mean; no number in the first of them.
        changed: (quantities, dives) whether the quantity changed in this dive.
        smallest: (quantities, dives) difference from that mean beyond which this dive would have shown a change.
    """

    reference: Array
    reference_error: Array
    p_value: Array
    changed: NDArray[np.bool_]
    smallest: Array


def changes(estimate: Array, error: Array, freedom: Array, share: Array) -> Changes:
    """The test, dive by dive.

    The variance of the mean counts that its weights are estimates (P. Meier, Variance of a weighted mean, Biometrics 9,
    1953), and the difference has the degrees of freedom of Satterthwaite.

    Args:
        estimate, error: (quantities, dives) with standard errors; no number where a dive lacks the quantity.
        freedom: (quantities, dives) degrees of freedom of the errors.
        share: (quantities,) part of the level that each may spend: one over the quantities of its vehicle.
    """
    reference, reference_error, p_value, smallest = (np.full(estimate.shape, np.nan) for _ in range(4))
    changed = np.zeros(estimate.shape, dtype=np.bool_)
    number = np.zeros(estimate.shape[0])
    weights, squares, total, least = (np.zeros(estimate.shape[0]) for _ in range(4))
    for k in range(estimate.shape[1]):
        there = np.isfinite(estimate[:, k]) & (error[:, k] > 0.0)
        tested = np.flatnonzero(there & (weights > 0.0))
        number += there
        w, f = weights[tested], least[tested]
        alike = squares[tested] / w**2
        mean, variance = total[tested] / w, (1.0 + 4.0 * (1.0 - alike) / f) / w
        own = error[tested, k] ** 2
        together = (own + variance) ** 2 / (own**2 / freedom[tested, k] + variance**2 * alike / f)
        apart = np.abs(estimate[tested, k] - mean) / np.sqrt(own + variance)
        reference[tested, k], reference_error[tested, k] = mean, np.sqrt(variance)
        p_value[tested, k] = 2.0 * stdtr(together, -apart)
        dives = number[tested] - 1.0
        level = LEVEL * share[tested] / (dives * (dives + 1.0))
        changed[tested, k] = p_value[tested, k] < level
        smallest[tested, k] = -stdtrit(together, 0.5 * level) * np.sqrt(own + variance)
        begins = there & (changed[:, k] | (weights == 0.0))
        one = np.where(there, 1.0 / np.where(there, error[:, k], 1.0) ** 2, 0.0)
        weights = np.where(begins, one, weights + one)
        squares = np.where(begins, one**2, squares + one**2)
        value = one * np.where(there, estimate[:, k], 0.0)
        total = np.where(begins, value, total + value)
        smaller = np.where(there, freedom[:, k], np.inf)
        least = np.where(begins, smaller, np.minimum(np.where(least > 0.0, least, np.inf), smaller))
    return Changes(reference, reference_error, p_value, changed, smallest)


def determined(estimate: Array, error: Array, freedom: Array) -> NDArray[np.bool_]:
    """Whether an inertia or a drag is known at all: it is positive, and its interval of 95 % no wider than itself."""
    return np.asarray(2.0 * stdtrit(freedom, 0.975) * error <= estimate)
