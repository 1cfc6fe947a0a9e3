"""Weighted vectors over several velocities: samples of about the same velocities in one, as their mean."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from incsvr.learning.several_velocities.drag import Drag
from incsvr.learning.several_velocities.velocities import distances, points, samples_with
from incsvr.numerics import Array
from incsvr.signals.samples import Samples


@dataclass(frozen=True, slots=True)
class Vectors:
    """Means of samples.

    The drag of mean velocities is not the mean drag, so that each keeps its mean terms as well: what the drag says of a
    vector is then what it says of its samples, however far these lie apart.

    Attributes:
        own: the axis's own velocity, as recordings call it.
        others: names of the further velocities, in the order of every (n, d) array.
        points: (n,) mean velocities and damping of each and the time of its newest sample.
        terms: (n, p) mean terms of the drag, of velocities in their units.
        information: (n,) Σ 1/σ² of the samples in each, at the noise level σ of their time [1/(N m)²].
    """

    own: str
    others: tuple[str, ...]
    points: Samples
    terms: Array
    information: Array

    def __len__(self) -> int:
        return len(self.points)

    def to_dict(self) -> dict[str, Any]:
        points = self.points
        return {
            "time": points.time.tolist(),
            "yaw_rate": points.yaw_rate.tolist(),
            "damping": points.damping.tolist(),
            "own": self.own,
            "others": {name: points.channels[name].tolist() for name in self.others},
            "terms": self.terms.tolist(),
            "information": self.information.tolist(),
        }

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> Vectors:
        time, rate, damping, information = (
            np.array(data[name], dtype=np.float64) for name in ("time", "yaw_rate", "damping", "information")
        )
        others = {name: np.array(values, dtype=np.float64) for name, values in data["others"].items()}
        if not time.size:  # of no vectors the terms do not say how many they are
            return Vectors.empty(data["own"], tuple(others))
        terms = np.array(data["terms"], dtype=np.float64).reshape(time.size, -1)
        return Vectors(data["own"], tuple(others), Samples(time, rate, damping, others), terms, information)

    @staticmethod
    def empty(own: str, others: tuple[str, ...]) -> Vectors:
        nothing = np.empty(0)
        points = Samples(nothing, nothing, nothing, dict.fromkeys(others, nothing))
        return Vectors(own, others, points, Drag.of(own, others).terms(np.empty((0, 1 + len(others)))), nothing)

    @staticmethod
    def of(own: str, others: tuple[str, ...], samples: Samples, information: float) -> Vectors:
        """Each of the (n,) samples as a vector of its own."""
        terms = Drag.of(own, others).terms(points(samples, others))
        return Vectors(own, others, samples, terms, np.full(len(samples), information))

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
            return Vectors.of(self.own, self.others, samples, each)
        mine, new = points(self.points, self.others), points(samples, self.others)
        apart = distances(new / fastest, mine / fastest)
        nearest = apart.argmin(axis=1)
        close = apart[np.arange(len(samples)), nearest] < radius
        to, n = nearest[close], len(self)
        joining = each * np.bincount(to, minlength=n)
        total = self.information + joining

        joins = np.zeros((n, int(close.sum())))
        joins[to, np.arange(to.size)] = each

        def mean(old: Array, fresh: Array) -> Array:
            """(n, k) of the vectors' own (n, k) and the samples' (m, k)."""
            return np.asarray((self.information[:, None] * old + joins @ fresh[close]) / total[:, None])

        velocity = mean(mine, new)
        time = self.points.time.copy()
        time[to] = samples.time[close]  # in their order: the newest stays
        damping = mean(self.points.damping[:, None], samples.damping[:, None])[:, 0]
        terms, loose = Drag.of(self.own, self.others).terms(new), samples.take(~close)
        return Vectors(
            self.own,
            self.others,
            Samples.concatenate((samples_with(time, velocity, damping, self.others), loose)),
            np.concatenate((mean(self.terms, terms), terms[~close])),
            np.concatenate((np.minimum(total, most), np.full(len(loose), each))),
        )

    def within(self, u: Array, fastest: Array, reach: float) -> Array:
        """Information of all vectors within `reach` of each of (n, d) scaled velocities, (n,) [1/(N m)²]."""
        near = distances(u, points(self.points, self.others) / fastest) <= reach
        return np.asarray(near @ self.information)

    def without(self, others: Vectors) -> Samples:
        """The points of which the others hold none with the same own velocity."""
        return self.points.take(~np.isin(self.points.yaw_rate, others.points.yaw_rate))

    def condense(self, fastest: Array, capacity: int, *, most: float) -> Vectors:
        """Forget: while there are more than `capacity`, the two closest become their weighted mean."""
        if len(self) <= capacity:
            return self
        velocity, damping, terms = points(self.points, self.others), self.points.damping.copy(), self.terms.copy()
        time, information = self.points.time.copy(), self.information.copy()
        apart = distances(velocity / fastest, velocity / fastest)
        np.fill_diagonal(apart, np.inf)
        alive = np.ones(len(self), dtype=bool)
        for _ in range(len(self) - capacity):
            i, j = divmod(int(apart.argmin()), len(self))
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
        kept = samples_with(time[alive], velocity[alive], damping[alive], self.others)
        return Vectors(self.own, self.others, kept, terms[alive], information[alive])
