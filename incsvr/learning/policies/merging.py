"""Weighted vectors: samples of about the same velocities in one, as their mean with the information of all of them.

Over one velocity they stand in its order, so that neighbours are found by bisection; over several, by their distances.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from incsvr.learning.criteria import Mask
from incsvr.learning.plain_samples import columns_to_dict, samples_from_dict
from incsvr.learning.several_velocities.drag import Drag
from incsvr.learning.velocities import distances, points, samples_with
from incsvr.numerics import Array
from incsvr.signals.samples import Samples


@dataclass(frozen=True, slots=True)
class Vectors:
    """Means of samples.

    The drag of mean velocities is not the mean drag, so that over several velocities each vector keeps its mean terms
    as well: what the drag says of a vector is then what it says of its samples, however far these lie apart.

    Attributes:
        points: (n,) mean velocities and damping of each and the time of its newest sample.
        information: (n,) Σ 1/σ² of the samples in each, at the noise level σ of their time [1/(N m)²].
        terms: (n, p) mean terms of the drag, of velocities in their units; (n, 0) over one velocity.
        own: the axis's own velocity, as recordings call it, for the drag.
        others: names of the further velocities, in the order of every (n, d) array; none over one velocity.
    """

    points: Samples
    information: Array
    terms: Array
    own: str = "yaw_rate"
    others: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.points)

    def to_dict(self) -> dict[str, Any]:
        plain = columns_to_dict(self.points)
        if self.others:
            others = {name: self.points.channels[name].tolist() for name in self.others}
            plain |= {"own": self.own, "others": others, "terms": self.terms.tolist()}
        return plain | {"information": self.information.tolist()}

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> Vectors:
        means, information = samples_from_dict(data), np.array(data["information"], dtype=np.float64)
        own, others = data.get("own", "yaw_rate"), tuple(means.channels)
        if not len(means):  # of no vectors the terms do not say how many they are
            return Vectors.of(means, own, others, information=0.0)
        terms = np.array(data.get("terms", ()), dtype=np.float64).reshape(len(means), -1)
        return Vectors(means, information, terms, own, others)

    @staticmethod
    def of(samples: Samples, own: str = "yaw_rate", others: tuple[str, ...] = (), *, information: float) -> Vectors:
        """Each of the (n,) samples as a vector of its own."""
        terms = _terms(samples, own, others)
        return Vectors(samples, np.full(len(samples), information), terms, own, others)._ordered()

    @staticmethod
    def empty(own: str = "yaw_rate", others: tuple[str, ...] = ()) -> Vectors:
        nothing = np.empty(0)
        return Vectors.of(
            Samples(nothing, nothing, nothing, dict.fromkeys(others, nothing)), own, others, information=0
        )

    def absorb(self, samples: Samples, fastest: Array, radius: float, *, each: float, most: float) -> Vectors:
        """Include: a sample within `radius` of a vector becomes part of the nearest, any other a vector itself.

        Args:
            samples: the new ones, (m,).
            fastest: (d,) by which each velocity is scaled.
            radius: in fastest velocities; over one velocity in [rad/s].
            each: information of one sample, 1/σ² [1/(N m)²].
            most: a vector's information stays below this [1/(N m)²]: beyond, its mean runs with the newest.
        """
        if not len(self):
            return Vectors.of(samples, self.own, self.others, information=each)
        nearest, close = self._nearest(samples, fastest, radius)
        to, joining, loose = nearest[close], samples.take(close), samples.take(~close)
        total = self.information + each * np.bincount(to, minlength=len(self))
        time = self.points.time.copy()
        time[to] = joining.time  # in their order: the newest stays
        join = _joined_by_distance if self.others else _joined_in_order
        velocity, damping, terms = join(self, joining, to, each, total)
        return Vectors(
            Samples.concatenate((samples_with(time, velocity, damping, self.others), loose)),
            np.concatenate((np.minimum(total, most), np.full(len(loose), each))),
            np.concatenate((terms, _terms(loose, self.own, self.others))),
            self.own,
            self.others,
        )._ordered()

    def within(self, samples: Samples, fastest: Array, reach: float) -> Array:
        """Information of all vectors within `reach` of each of (n,) samples, (n,) [1/(N m)²]; `reach` as `radius`."""
        if self.others:
            return np.asarray((self._distances(samples, fastest) <= reach) @ self.information)
        rate, known = samples.yaw_rate, self.points.yaw_rate
        sums = np.concatenate(([0.0], np.cumsum(self.information)))
        first, last = known.searchsorted(rate - reach), known.searchsorted(rate + reach, side="right")
        return np.asarray(sums[last] - sums[first])

    def without(self, others: Vectors) -> Samples:
        """The points of which the others hold none with the same own velocity."""
        if others is self:
            return self.points.take(slice(0, 0))
        return self.points.take(~(self.points.yaw_rate[:, None] == others.points.yaw_rate).any(axis=1))

    def condense(self, fastest: Array, capacity: int, *, most: float) -> Vectors:
        """Forget: while there are more than `capacity`, the two closest become their weighted mean."""
        if len(self) <= capacity:
            return self
        if self.others:
            return _condensed_by_distance(self, fastest, capacity, most)
        return _condensed_in_order(self, capacity, most)

    def _ordered(self) -> Vectors:
        """Over one velocity in its order."""
        if self.others:
            return self
        order = self.points.yaw_rate.argsort(kind="stable")
        return Vectors(self.points.take(order), self.information[order], self.terms, self.own)

    def _nearest(self, samples: Samples, fastest: Array, radius: float) -> tuple[NDArray[np.intp], Mask]:
        """(m,) the nearest vector of each sample, and whether it lies within the radius."""
        if self.others:
            apart = self._distances(samples, fastest)
            nearest = apart.argmin(axis=1)
            return nearest, apart[np.arange(len(samples)), nearest] < radius
        rate = self.points.yaw_rate
        nearest = np.searchsorted(0.5 * (rate[1:] + rate[:-1]), samples.yaw_rate)
        return nearest, np.abs(samples.yaw_rate - rate[nearest]) < radius

    def _distances(self, samples: Samples, fastest: Array) -> Array:
        """(m, n) between samples and vectors, in fastest velocities."""
        return distances(points(samples, self.others) / fastest, points(self.points, self.others) / fastest)


def _terms(samples: Samples, own: str, others: tuple[str, ...]) -> Array:
    """(n, p) terms of the drag; none over one velocity, where no drag stands beside the kernels."""
    return Drag.of(own, others).terms(points(samples, others)) if others else np.empty((len(samples), 0))


def _joined_in_order(
    vectors: Vectors, samples: Samples, to: NDArray[np.intp], each: float, total: Array
) -> tuple[Array, Array, Array]:
    """Over one velocity: the mean velocity (n, 1), damping (n,) and terms (n, 0) of vectors that samples join.

    Args:
        samples: (m,) of them.
        to: (m,) the vector that each joins.
        each: information of one sample [1/(N m)²].
        total: (n,) information of the vectors with their new samples.
    """
    means = vectors.points
    rate, damping = (
        (vectors.information * old + each * np.bincount(to, new, len(vectors))) / total
        for old, new in ((means.yaw_rate, samples.yaw_rate), (means.damping, samples.damping))
    )
    return rate[:, None], damping, vectors.terms


def _joined_by_distance(
    vectors: Vectors, samples: Samples, to: NDArray[np.intp], each: float, total: Array
) -> tuple[Array, Array, Array]:
    """Over several velocities: the mean velocities (n, d), damping (n,) and terms (n, p); as `_joined_in_order`."""
    own, others, joins = vectors.own, vectors.others, np.zeros((len(vectors), len(samples)))
    joins[to, np.arange(to.size)] = each
    velocity, damping, terms = (
        (vectors.information[:, None] * old + joins @ new) / total[:, None]
        for old, new in (
            (points(vectors.points, others), points(samples, others)),
            (vectors.points.damping[:, None], samples.damping[:, None]),
            (vectors.terms, _terms(samples, own, others)),
        )
    )
    return velocity, damping[:, 0], terms


def _condensed_in_order(vectors: Vectors, capacity: int, most: float) -> Vectors:
    """Over one velocity: the closest two are neighbours, and stay in order as their mean."""
    rate, damping = vectors.points.yaw_rate.tolist(), vectors.points.damping.tolist()
    time, information = vectors.points.time.tolist(), vectors.information.tolist()
    gaps = np.diff(vectors.points.yaw_rate).tolist()
    for _ in range(len(vectors) - capacity):
        i = gaps.index(min(gaps))
        left, right = information[i], information[i + 1]
        total = left + right
        rate[i] = (left * rate[i] + right * rate[i + 1]) / total
        damping[i] = (left * damping[i] + right * damping[i + 1]) / total
        time[i], information[i] = max(time[i], time[i + 1]), min(total, most)
        del rate[i + 1], damping[i + 1], time[i + 1], information[i + 1], gaps[i]
        if i < len(gaps):
            gaps[i] = rate[i + 1] - rate[i]
        if i > 0:
            gaps[i - 1] = rate[i] - rate[i - 1]
    return Vectors(
        Samples(np.array(time), np.array(rate), np.array(damping)),
        np.array(information),
        vectors.terms[:capacity],
        vectors.own,
    )


def _condensed_by_distance(vectors: Vectors, fastest: Array, capacity: int, most: float) -> Vectors:
    """Over several velocities: the closest two of all pairs."""
    velocity, terms = points(vectors.points, vectors.others), vectors.terms.copy()
    damping, time, information = vectors.points.damping.copy(), vectors.points.time.copy(), vectors.information.copy()
    apart = distances(velocity / fastest, velocity / fastest)
    np.fill_diagonal(apart, np.inf)
    alive = np.ones(len(vectors), dtype=bool)
    for _ in range(len(vectors) - capacity):
        i, j = divmod(int(apart.argmin()), len(vectors))
        left, right = information[i], information[j]
        for values in (velocity, damping, terms):
            values[i] = (left * values[i] + right * values[j]) / (left + right)
        time[i], information[i] = max(time[i], time[j]), min(left + right, most)
        alive[j] = False
        apart[j], apart[:, j] = np.inf, np.inf
        fresh = distances(velocity[i : i + 1] / fastest, velocity / fastest)[0]
        fresh[~alive] = np.inf
        fresh[i] = np.inf
        apart[i], apart[:, i] = fresh, fresh
    means = samples_with(time[alive], velocity[alive], damping[alive], vectors.others)
    return Vectors(means, information[alive], terms[alive], vectors.own, vectors.others)
