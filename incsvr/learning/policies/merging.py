"""Weighted vectors: samples of about the same yaw rate in one, as their mean with the information of all of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from incsvr.numerics import Array
from incsvr.signals.samples import Samples


@dataclass(frozen=True, slots=True)
class Vectors:
    """Means of samples, in the order of their yaw rate.

    Attributes:
        points: (n,) mean yaw rate and damping of each and the time of its newest sample.
        information: (n,) Σ 1/σ² of the samples in each, at the noise level σ of their time [1/(N m)²].
    """

    points: Samples
    information: Array

    def __len__(self) -> int:
        return len(self.points)

    def to_dict(self) -> dict[str, Any]:
        points = self.points
        return {
            "time": points.time.tolist(),
            "yaw_rate": points.yaw_rate.tolist(),
            "damping": points.damping.tolist(),
            "information": self.information.tolist(),
        }

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> Vectors:
        time, rate, damping, information = (
            np.array(data[name], dtype=np.float64) for name in ("time", "yaw_rate", "damping", "information")
        )
        return Vectors(Samples(time, rate, damping), information)

    @staticmethod
    def empty() -> Vectors:
        return Vectors(Samples.empty(), np.empty(0))

    @staticmethod
    def of(samples: Samples, *, information: float) -> Vectors:
        """Each of the (n,) samples as a vector of its own."""
        order = np.argsort(samples.yaw_rate, kind="stable")
        return Vectors(samples.take(order), np.full(order.size, information))

    def absorb(self, samples: Samples, *, radius: float, each: float, most: float) -> Vectors:
        """Include: a sample within `radius` of a vector becomes part of it, any other becomes a vector itself.

        Args:
            samples: the new ones, (m,).
            radius: [rad/s].
            each: information of one sample, 1/σ² [1/(N m)²].
            most: a vector's information stays below this [1/(N m)²]: beyond, its mean runs with the newest.
        """
        points, information = self.points, self.information
        rate, damping, time = points.yaw_rate, points.damping, points.time
        loose = samples
        if len(self):
            edges = 0.5 * (rate[1:] + rate[:-1])
            nearest = np.searchsorted(edges, samples.yaw_rate)
            close = np.abs(samples.yaw_rate - rate[nearest]) < radius
            loose, joining, to = samples.take(~close), samples.take(close), nearest[close]
            new = each * np.bincount(to, minlength=rate.size)
            total = information + new
            rate = (information * rate + each * np.bincount(to, joining.yaw_rate, rate.size)) / total
            damping = (information * damping + each * np.bincount(to, joining.damping, rate.size)) / total
            time = time.copy()
            time[to] = joining.time  # in their order: the newest stays
            information = np.minimum(total, most)
        together = Samples(time, rate, damping)
        if len(loose):
            together = Samples.concatenate((together, loose))
            information = np.concatenate((information, np.full(len(loose), each)))
        order = together.yaw_rate.argsort(kind="stable")
        return Vectors(together.take(order), information[order])

    def within(self, rate: Array, reach: float) -> Array:
        """Information of all vectors within `reach` [rad/s] of each of (n,) rates [rad/s], (n,) [1/(N m)²]."""
        known = self.points.yaw_rate
        held = np.concatenate(([0.0], np.cumsum(self.information)))
        first, last = known.searchsorted(rate - reach), known.searchsorted(rate + reach, side="right")
        return np.asarray(held[last] - held[first])

    def without(self, others: Vectors) -> Samples:
        """The points whose yaw rate is none of the others'."""
        if others is self:
            return Samples.empty()
        stays = (self.points.yaw_rate[:, None] == others.points.yaw_rate).any(axis=1)
        return self.points.take(~stays)

    def condense(self, capacity: int, *, most: float) -> Vectors:
        """Forget: while there are more than `capacity`, the two closest neighbours become their weighted mean."""
        excess = len(self) - capacity
        if excess <= 0:
            return self
        rate, damping = self.points.yaw_rate.tolist(), self.points.damping.tolist()
        time, information = self.points.time.tolist(), self.information.tolist()
        gaps = np.diff(self.points.yaw_rate).tolist()
        for _ in range(excess):
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
        return Vectors(Samples(np.array(time), np.array(rate), np.array(damping)), np.array(information))
