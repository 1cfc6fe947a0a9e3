"""Weighted vectors: samples of about the same velocities in one, as their mean with the information of all of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

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
    """

    # (n,) mean velocities and damping of each and the time of its newest sample, in the order of the own velocity
    points: Samples
    information: Array  # (n,) Σ 1/σ² of the samples in each, at the noise level σ of their time [1/(N m)²]
    terms: Array  # (n, p) mean terms of the drag, of velocities in their units; (n, 0) over one velocity
    own: str = "yaw_rate"  # the axis's own velocity, as recordings call it, for the drag
    # names of the further velocities, in the order of every (n, d) array; none over one velocity
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
        samples = samples.take(samples.yaw_rate.argsort(kind="stable"))
        terms = _terms(points(samples, others), own, others)
        return Vectors(samples, np.full(len(samples), information), terms, own, others)

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
            radius: in fastest velocities.
            each: information of one sample, 1/σ² [1/(N m)²].
            most: a vector's information stays below this [1/(N m)²]: beyond, its mean runs with the newest.
        """
        if not len(self):
            return Vectors.of(samples, self.own, self.others, information=each)
        apart = self._distances(samples, fastest)
        nearest = apart.argmin(axis=1)
        close = apart[np.arange(len(samples)), nearest] < radius
        loose = np.flatnonzero(~close)
        new, old, to = self._columns(samples), self._columns(self.points, self.terms), nearest[close]
        joins = np.zeros((len(self), to.size))
        joins[to, np.arange(to.size)] = each
        total = self.information + each * np.bincount(to, minlength=len(self))
        means = (self.information[:, None] * old + joins @ new[close]) / total[:, None]
        time = self.points.time.copy()
        time[to] = samples.time[close]  # in their order: the newest stays
        return self._with(
            np.concatenate((time, samples.time[loose])),
            np.concatenate((means, new[loose])),
            np.concatenate((np.minimum(total, most), np.full(loose.size, each))),
        )

    def within(self, samples: Samples, fastest: Array, reach: float) -> Array:
        """Information of all vectors within `reach` of each of (n,) samples, (n,) [1/(N m)²]; `reach` as `radius`."""
        return np.asarray((self._distances(samples, fastest) <= reach) @ self.information)

    def without(self, others: Vectors) -> Samples:
        """The points of which the others hold none with the same own velocity."""
        if others is self:
            return self.points.take(slice(0, 0))
        return self.points.take(~(self.points.yaw_rate[:, None] == others.points.yaw_rate).any(axis=1))

    def condense(self, fastest: Array, capacity: int, *, most: float) -> Vectors:
        """Forget: while there are more than `capacity`, the two closest become their weighted mean."""
        if len(self) <= capacity:
            return self
        condensed = _by_distance if self.others else _in_order
        return condensed(self, fastest, len(self) - capacity, most)

    def _columns(self, samples: Samples, terms: Array | None = None) -> Array:
        """(n, d + 1 + p) what is averaged of samples: velocities, damping, terms of the drag."""
        velocity = points(samples, self.others)
        terms = _terms(velocity, self.own, self.others) if terms is None else terms
        return np.concatenate((velocity, samples.damping[:, None], terms), axis=1)

    def _with(self, time: Array, columns: Array, information: Array) -> Vectors:
        """Vectors of these `_columns`, over the same velocities, in the order of the own one."""
        d, order = 1 + len(self.others), columns[:, 0].argsort(kind="stable")
        columns = columns[order]
        means = samples_with(time[order], columns[:, :d], columns[:, d], self.others)
        return Vectors(means, information[order], columns[:, d + 1 :], self.own, self.others)

    def _distances(self, samples: Samples, fastest: Array) -> Array:
        """(m, n) between samples and vectors, in fastest velocities."""
        return distances(points(samples, self.others) / fastest, points(self.points, self.others) / fastest)


def _terms(velocity: Array, own: str, others: tuple[str, ...]) -> Array:
    """(n, p) terms of the drag; none over one velocity, where no drag stands beside the kernels."""
    return Drag.of(own, others).terms(velocity) if others else np.empty((len(velocity), 0))


def _in_order(vectors: Vectors, _: Array, merges: int, most: float) -> Vectors:
    """Over one velocity: the closest two are neighbours, and stay in order as their mean."""
    rate, damping = vectors.points.yaw_rate.tolist(), vectors.points.damping.tolist()
    time, information = vectors.points.time.tolist(), vectors.information.tolist()
    gaps = np.diff(vectors.points.yaw_rate).tolist()
    for _merge in range(merges):
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
    return vectors._with(np.array(time), np.array((rate, damping)).T, np.array(information))


def _by_distance(vectors: Vectors, fastest: Array, merges: int, most: float) -> Vectors:
    """Over several velocities: the closest two of all pairs."""
    columns = vectors._columns(vectors.points, vectors.terms)
    time, information = vectors.points.time.copy(), vectors.information.copy()
    scaled = columns[:, : fastest.size]
    apart = distances(scaled / fastest, scaled / fastest)
    np.fill_diagonal(apart, np.inf)
    alive = np.ones(len(vectors), dtype=bool)
    for _ in range(merges):
        i, j = divmod(int(apart.argmin()), len(vectors))
        left, right = information[i], information[j]
        columns[i] = (left * columns[i] + right * columns[j]) / (left + right)
        time[i], information[i] = max(time[i], time[j]), min(left + right, most)
        alive[j] = False
        fresh = distances(scaled[i : i + 1] / fastest, scaled / fastest)[0]
        fresh[~alive] = np.inf
        fresh[i] = np.inf
        apart[j], apart[:, j] = np.inf, np.inf
        apart[i], apart[:, i] = fresh, fresh
    return vectors._with(time[alive], columns[alive], information[alive])
