"""Weighted vectors: samples of about the same velocities in one, as their mean with the information of all of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from incsvr.learning.drag import Drag, distances, points
from incsvr.numerics import Array
from incsvr.signals.samples import Samples


@dataclass(frozen=True, slots=True)
class Vectors:
    """Means of samples.

    The drag of mean velocities is not the mean drag, so that over several velocities each vector keeps its mean terms
    as well: what the drag says of a vector is then what it says of its samples, however far these lie apart.
    """

    time: Array  # (n,) of the newest sample in each [s]
    yaw_rate: Array  # (n,) mean own velocity of each, increasing, and mean damping
    damping: Array
    information: Array  # (n,) Σ 1/σ² of the samples in each, at the noise level σ of their time [1/(N m)²]
    terms: Array = field(default_factory=lambda: np.empty(0))  # (n, p) mean terms of the drag, of unscaled velocities
    own: str = "yaw_rate"  # the axis's own velocity, as recordings call it, for the drag
    # (n,) mean of each further velocity; none over one velocity
    others: Mapping[str, Array] = field(default_factory=dict)

    def __len__(self) -> int:
        return self.time.size

    @property
    def samples(self) -> Samples:
        """The vectors as samples."""
        return Samples(self.time, self.yaw_rate, self.damping, self.others)

    @staticmethod
    def of(samples: Samples, own: str, others: Sequence[str], *, information: float) -> Vectors:
        """Each of the (n,) samples as a vector of its own."""
        return _vectors(samples.time, _columns(samples, own, others), np.full(len(samples), information), own, others)

    @staticmethod
    def empty(own: str = "yaw_rate", others: Sequence[str] = ()) -> Vectors:
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
            return Vectors.of(samples, self.own, tuple(self.others), information=each)
        apart = self._distances(samples, fastest)
        nearest = apart.argmin(axis=1)
        close = apart[np.arange(len(samples)), nearest] < radius
        loose = np.flatnonzero(~close)
        new, to = _columns(samples, self.own, tuple(self.others)), nearest[close]
        joins = np.zeros((len(self), to.size))
        joins[to, np.arange(to.size)] = each
        total = self.information + each * np.bincount(to, minlength=len(self))
        means = (self.information[:, None] * self._means + joins @ new[close]) / total[:, None]
        time = self.time.copy()
        time[to] = samples.time[close]  # in their order: the newest stays
        time, means = np.concatenate((time, samples.time[loose])), np.concatenate((means, new[loose]))
        information = np.concatenate((np.minimum(total, most), np.full(loose.size, each)))
        return _vectors(time, means, information, self.own, tuple(self.others))

    def condense(self, fastest: Array, capacity: int, *, most: float) -> Vectors:
        """Forget: while there are more than `capacity`, the closest two become their weighted mean.

        Of all that are each other's nearest the closest do so at once.
        """
        if len(self) <= capacity:
            return self
        columns, time, information = self._means, self.time, self.information
        while (excess := time.size - capacity) > 0:
            scaled = columns[:, : fastest.size] / fastest
            apart = distances(scaled, scaled)
            apart.reshape(-1)[:: time.size + 1] = np.inf
            nearest, place = apart.argmin(axis=1), np.arange(time.size)
            i = np.flatnonzero((nearest[nearest] == place) & (place < nearest))
            i = i[apart[i, nearest[i]].argsort(kind="stable")[:excess]]
            j = nearest[i]
            left, right = information[i], information[j]
            merged = (left[:, None] * columns[i] + right[:, None] * columns[j]) / (left + right)[:, None]
            columns, time, information = columns.copy(), time.copy(), information.copy()
            columns[i], time[i], information[i] = merged, np.maximum(time[i], time[j]), np.minimum(left + right, most)
            stays = np.ones(time.size, dtype=bool)
            stays[j] = False
            columns, time, information = columns[stays], time[stays], information[stays]
        return _vectors(time, columns, information, self.own, tuple(self.others))

    def within(self, samples: Samples, fastest: Array, reach: float) -> Array:
        """Information of all vectors within `reach` of each of (n,) samples, (n,) [1/(N m)²]; `reach` as `radius`."""
        return np.asarray((self._distances(samples, fastest) <= reach) @ self.information)

    def without(self, others: Vectors) -> Samples:
        """The vectors of which the others hold none with the same own velocity, as samples."""
        if others is self:
            return Samples.empty()
        return self.samples.take(~(self.yaw_rate[:, None] == others.yaw_rate).any(axis=1))

    @property
    def _means(self) -> Array:
        """(n, d + 1 + p) what is averaged of samples, as `_columns`."""
        velocity = points(self.samples, tuple(self.others))
        return np.concatenate((velocity, self.damping[:, None], self.terms.reshape(len(self), -1)), axis=1)

    def _distances(self, samples: Samples, fastest: Array) -> Array:
        """(m, n) between samples and vectors, in fastest velocities."""
        others = tuple(self.others)
        return distances(points(samples, others) / fastest, points(self.samples, others) / fastest)


def _columns(samples: Samples, own: str, others: Sequence[str]) -> Array:
    """(n, d + 1 + p) of samples: velocities, damping, and terms of the drag where one stands beside the kernels."""
    velocity = points(samples, others)
    terms = Drag.of(own, others).terms(velocity) if others else np.empty((len(samples), 0))
    return np.concatenate((velocity, samples.damping[:, None], terms), axis=1)


def _vectors(time: Array, columns: Array, information: Array, own: str, others: Sequence[str]) -> Vectors:
    """Vectors of these columns, in the order of the own velocity."""
    order, d = columns[:, 0].argsort(kind="stable"), 1 + len(others)
    columns = columns[order]
    further = dict(zip(others, columns[:, 1:d].T, strict=True))
    return Vectors(time[order], columns[:, 0], columns[:, d], information[order], columns[:, d + 1 :], own, further)
