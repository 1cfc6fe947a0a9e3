"""What data before and after an instant say about a change of thrust, of damping, of a moment or of the inertia there.

Errors of prediction are linear in what causes them, and white: sums of squares and of products before and after an
onset are all that the data say of it. What is before it tells the usual sizes of p causes, and how well they are known;
what is after it weighs, by its marginal likelihood, whether they are still the same, or one of them is another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array

CHANGE_PRIORS = {"thrust": (0.4, 0.0, 0.0), "damping": (0.0, 0.5, 0.0), "moment": (0.0, 0.0, 0.3),
                 "inertia": (0.3, -0.3, 0.0)}  # fmt: skip
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


@dataclass(frozen=True)
class ThrustEvidence:
    """The sums for each of k onsets, in units of the causes' usual size.

    Attributes:
        known, asked: (k, p, p) and (k, p) sums of the causes' squares and of their products with the errors before it.
        fresh, drawn: the same after it.
        power: (k,) sum of the errors' squares after it.
        count: (k,) errors after it.
        units: (p,) what one of each prior's unit is, in the causes' usual size.
        variance: of the noise.
        drifts: deviations of the first three causes between stretches in which nothing happens.
    """

    known: Array
    asked: Array
    fresh: Array
    drawn: Array
    power: Array
    count: NDArray[np.intp]
    units: Array
    variance: float
    drifts: tuple[float, float, float] = MIN_DRIFTS

    @staticmethod
    def of(white: Array, causes: Array, onsets: NDArray[np.intp], units: Array, variance: float) -> ThrustEvidence:
        """From (n,) white errors and (n, p) causes that are filtered likewise, and onsets (k,) from 1 to n − 1."""
        pieces = _sums(white, causes, (0, *onsets.tolist(), white.size))
        total = np.cumsum(pieces, axis=0)
        return ThrustEvidence._of_sums(total[:-1], total[-1] - total[:-1], white.size - onsets, units, variance)

    @staticmethod
    def _of_sums(before: Array, after: Array, count: NDArray[np.intp], units: Array, variance: float) -> ThrustEvidence:
        return ThrustEvidence(
            before[:, :-1, :-1], before[:, :-1, -1], after[:, :-1, :-1], after[:, :-1, -1], after[:, -1, -1],
            count, units, variance,
        )  # fmt: skip

    def with_drift_of(self, white: Array, causes: Array, length: int) -> ThrustEvidence:
        """This evidence with the drift of the thrust measured: the root mean square by which the lacking thrust of one
        stretch before the onsets differs from that of all other stretches, less what noise explains of it.

        Args:
            white, causes: (n,) and (n, p) of the data before the onsets.
            length: of a stretch.
        """
        last = white.size // length * length
        if last == 0:
            return self
        pieces = _sums(white, causes, (*range(0, last + 1, length), white.size))
        rest = np.sum(pieces, axis=0) - pieces[:-1]
        count = np.full(last // length, length)
        stretches = self._of_sums(rest, pieces[:-1], count, self.units, self.variance)
        more, doubt = np.array([stretches.lacking(k)[1:] for k in range(count.size)]).T
        drift = float(np.sqrt(max(np.mean(more**2 - doubt**2), 0.0)))
        return replace(self, drifts=(max(drift, MIN_DRIFTS[0]), *MIN_DRIFTS[1:]))

    def likelihood(self, change: str | None) -> Array:
        """(k,) logarithm of the likelihood of all data if this changes at each onset, or nothing; the same constant is
        left out of all."""
        return self._before[2] + self._unchanged + self._changed(change)[0]

    def left(self, onset: int) -> float:
        """What a change of thrust at an onset leaves of the errors after it, in variances."""
        rest = self.power / self.variance - 2.0 * self._unchanged
        return float((rest - 2.0 * self._changed("thrust")[1])[onset] / self.count[onset])

    def lacking(self, onset: int) -> tuple[float, float, float]:
        """Thrust that was lacking before an onset, by how much more is lacking after it, as parts of the thrust, and
        the deviation of that."""
        mean, usual, _ = self._before
        fresh = self.fresh[onset] / self.variance
        spread = np.eye(self.units.size) + fresh @ usual[onset]
        information = np.linalg.solve(spread, fresh)[0, 0] + 1.0 / self._prior("thrust")[0, 0]
        more = np.linalg.solve(spread, self._pull[onset])[0] / information
        unit = float(self.units[0])
        return float(mean[onset][0]) / unit, float(more) / unit, float(information) ** -0.5 / unit

    @cached_property
    def _before(self) -> tuple[Array, Array, Array]:
        """(k, p) and (k, p, p) mean and covariance of the causes by the data before each onset, and (k,) the logarithm
        of these data's likelihood."""
        prior = np.diag(1.0 / (self.units * np.array(USUAL_PRIORS)) ** 2)
        information, asked = self.known / self.variance + prior, self.asked / self.variance
        mean = np.linalg.solve(information, asked[:, :, None])[:, :, 0]
        likelihood = 0.5 * np.sum(mean * asked, axis=1) - 0.5 * np.linalg.slogdet(information)[1]
        drift = self.units * np.pad(self.drifts, (0, self.units.size - len(self.drifts)))
        covariance: Array = np.linalg.inv(information) + np.diag(drift**2)
        return np.asarray(mean), covariance, np.asarray(likelihood)

    @cached_property
    def _pull(self) -> Array:
        """(k, p) how the data after each onset pull away from the mean before it."""
        mean = self._before[0]
        return np.asarray((self.drawn - (self.fresh @ mean[:, :, None])[:, :, 0]) / self.variance)

    @cached_property
    def _unchanged(self) -> Array:
        """(k,) what the mean before each onset explains of the errors after it, in logarithm of the likelihood."""
        mean = self._before[0]
        return np.asarray(0.5 * np.sum(mean * (self.drawn / self.variance + self._pull), axis=1))

    def _prior(self, change: str | None) -> Array:
        """(p, p) covariance of a change."""
        if change is None:
            return np.zeros((self.units.size, self.units.size))
        size = self.units * np.pad(CHANGE_PRIORS[change], (0, self.units.size - 3))
        return np.outer(size, size)

    def _changed(self, change: str | None) -> tuple[Array, Array]:
        """(k,) logarithm of the likelihood of the data after each onset beside that of the mean before it, and the part
        of it that is a fit."""
        prior, pull = self._before[1] + self._prior(change), self._pull
        inside = np.eye(self.units.size) + prior @ (self.fresh / self.variance)
        fit = 0.5 * np.sum(pull * np.linalg.solve(inside, prior @ pull[:, :, None])[:, :, 0], axis=1)
        return fit - 0.5 * np.linalg.slogdet(inside)[1], fit


def _sums(white: Array, causes: Array, bounds: Sequence[int]) -> Array:
    """(pieces, p + 1, p + 1) sums of squares and products of p causes and the errors between bounds."""
    both = np.column_stack((causes, white))
    return np.array([both[a:b].T @ both[a:b] for a, b in pairwise(bounds)])
