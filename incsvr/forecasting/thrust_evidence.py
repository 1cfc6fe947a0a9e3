"""What data before and after an instant say about a change of thrust, of damping, of a moment or of the inertia there.

Errors of prediction are linear in what causes them, and white: sums of squares and of products before and after an
onset are all that the data say of it. What is before it tells the usual sizes of p causes, and how well they are known;
what is after it weighs whether they are still the same, or one of them is another (`checks.evidence`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from incsvr.checks.evidence import Evidence
from incsvr.numerics import Array

CHANGES = ("thrust", "damping", "moment", "inertia")
CHANGE_PRIORS = np.array([[0.4, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.3], [0.3, -0.3, 0.0]])
"""Deviations of each change in the first three causes: thrust that is lacking and damping that has grown, as parts of
them, and a moment, in usual torques. An inertia that has shrunk is thrust that is lacking beside damping that is."""
MIN_DRIFTS = (0.03, 0.06, 0.06)
"""Smallest deviations of thrust, damping (as parts of them) and moment (in usual torques) from one stretch of data to
the next while nothing happens."""
CURVE_KNOTS = 6
"""Rates at which the learned curve may be off, each by its own error."""
LAG_COUNT = 5
"""Lags of the thrust that are told apart."""
USUAL_PRIORS = (0.3, 0.3, 0.3, *(1.0,) * LAG_COUNT, 0.2, 0.2, *(0.1,) * CURVE_KNOTS)
"""Deviations of all causes before anything is known: of thrust that is lacking and damping that has grown beside what
was learned, as parts of them, of a moment, in usual torques, of what comes late of the thrust, of its asymmetry and
curvature, as parts of it, and of the curve's errors, in usual torques."""


@dataclass(frozen=True, slots=True)
class ThrustEvidence:
    """The evidence at each of k onsets.

    Attributes:
        nothing: (k,) logarithm of the likelihood of all data if nothing changes; a constant is left out.
        changed: (k, 4) the same if each of CHANGES does.
        left: (k,) what a change of thrust leaves of the errors after the onset, in variances.
        more, doubt: (k,) by how much more of the usual thrust is lacking after it, and the deviation of that.
    """

    nothing: Array
    changed: Array
    left: Array
    more: Array
    doubt: Array

    @staticmethod
    def of(
        before: Array, after: Array, count: NDArray[np.intp], units: Array, drifts: Sequence[float]
    ) -> ThrustEvidence:
        """Weighs the changes.

        Args:
            before, after: (k, p + 1, p + 1) sums of the causes and the errors, in variances, before each onset and
                after it.
            count: (k,) errors after it.
            units: (p,) what one of each prior's unit is, in the causes' usual size.
            drifts: deviations of the first three causes between stretches in which nothing happens.
        """
        p, found = units.size, []
        first = np.diag((units * np.array(USUAL_PRIORS)) ** -2.0)
        drift = np.diag((units * np.pad(drifts, (0, p - len(drifts)))) ** 2)
        directions = units[:, None] * np.pad(CHANGE_PRIORS, ((0, 0), (0, p - 3))).T
        none, moved = (np.zeros((p, 0)), np.zeros(0), np.zeros(0)), np.eye(p + 1)
        for known, fresh, size in zip(before, after, count, strict=True):
            until = Evidence.of(known, first, *none)
            moved[:p, p] = -until.usual[:, -1]  # of the errors what is usual is taken
            prior = np.linalg.inv(np.linalg.inv(until.precision) + drift)
            since = Evidence.of(moved.T @ fresh @ moved, prior, directions, np.zeros(4), np.ones(4))
            nothing = until.nothing + since.nothing
            change = CHANGE_PRIORS[0, 0] * np.array([since.size[0], since.deviation[0]])
            found.append(np.concatenate(([nothing], nothing + since.odds, [since.cost[0] / size], change)))
        table = np.array(found).T
        return ThrustEvidence(table[0], table[1:5].T, *table[5:])


def drift_of_thrust(white: Array, causes: Array, length: int, units: Array, variance: float) -> float:
    """By how much the lacking thrust of one stretch differs from that of all others (root mean square), less what noise
    explains of it.

    Args:
        white, causes: (n,) and (n, p) errors and causes of data in which nothing happens.
        length: of a stretch.
    """
    last = white.size // length * length
    if last == 0:
        return 0.0
    pieces = sums(white, causes, (*range(0, last + 1, length), white.size)) / variance
    rest, count = np.sum(pieces, axis=0) - pieces[:-1], np.full(last // length, length)
    seen = ThrustEvidence.of(rest, pieces[:-1], count, units, MIN_DRIFTS)
    return float(np.sqrt(max(float(np.mean(seen.more**2 - seen.doubt**2)), 0.0)))


def sums(white: Array, causes: Array, bounds: Sequence[int]) -> Array:
    """(pieces, p + 1, p + 1) sums of squares and products of p causes and the errors between bounds."""
    both = np.column_stack((causes, white))
    return np.array([both[a:b].T @ both[a:b] for a, b in pairwise(bounds)])
