"""The paper's policy, to the letter (Fig. 3, Section III-C): inclusion → forgetting → stack → train → outlier removal.

The vectors and weights that the outlier removal leaves are carried into the next iteration, where the weights warm
Eq. 8's passes. They are not what is served. Every θ is near ±C and every kernel spans most of the range, so a sum from
which vectors have been struck out is off by thousands of N m: what is served is solved again on the vectors that the
next iteration's forgetting will keep, at most `capacity` of them.

It learns over one velocity, as the paper does.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from incsvr.learning.iteration import Iteration, Settings
from incsvr.learning.kernel import columns
from incsvr.learning.model import Model
from incsvr.learning.noise import Mask, Noise, outliers
from incsvr.learning.training import trained
from incsvr.numerics import Array
from incsvr.signals.samples import Samples


@dataclass(frozen=True, eq=False)
class Memory:
    """The memory of the paper's policy between two iterations."""

    time: Array  # (n,) of the vectors after outlier removal, oldest first, n ≤ capacity + batch [s]
    yaw_rate: Array  # their rates [rad/s] and damping [N m]
    damping: Array
    stays: Mask  # (n,) those that the next iteration's forgetting keeps: what is served
    noise: Noise  # of the samples about the curve
    weight: Array = field(default_factory=lambda: np.empty(0))  # (n,) their θ [N m]
    # (n,) further velocities of an earlier version's vectors, with which `weighted` goes on
    others: Mapping[str, Array] = field(default_factory=dict)

    @property
    def vectors(self) -> Samples:
        return Samples(self.time, self.yaw_rate, self.damping, self.others)

    @cached_property
    def served(self) -> Samples:
        """The vectors of the served model."""
        return self.vectors.take(self.stays)

    @property
    def fastest(self) -> Array:
        """(d − 1,) of each further velocity: zero, as before anything was driven."""
        return np.zeros(len(self.others))


def start(settings: Settings) -> Memory:
    nothing = np.empty(0)
    return Memory(nothing, nothing, nothing, np.empty(0, dtype=np.bool_), Noise.start(settings.rate_range))


def continued(settings: Settings, other: Any) -> Memory:
    """The memory that goes on from another policy's: its vectors as samples, one each."""
    old = other.served
    stays = np.ones(len(old), dtype=np.bool_)
    return Memory(old.time, old.yaw_rate, old.damping, stays, other.noise, np.zeros(len(old)))


def learn(
    settings: Settings,
    number: int,
    memory: Memory,
    model: Model,
    batch: Samples,
    predicted: Array | None,
    place: NDArray[np.intp],
) -> tuple[Memory, Iteration]:
    """Iteration `number` with a `batch` of n ≥ 1 samples.

    Args:
        memory, model: from before.
        predicted: (n,) f(x) of the batch under `model` [N m], None before there is one.
        place: (n,) where each sample stands in the stream: neighbours differ by one.
    """
    old = memory.served
    verdict = inclusion(settings, batch.yaw_rate, batch.damping, predicted, memory.yaw_rate, memory.damping)
    new = batch.take(verdict.kept)
    # Where no training takes place, nothing has to make room.
    forgotten, removed = memory.vectors.take(~memory.stays) if len(new) else Samples.empty(), Samples.empty()
    if len(new):
        stack, fastest = Samples.concatenate((old, new)), np.empty(0)
        warm = np.concatenate((memory.weight[memory.stays], np.zeros(len(new))))
        phi = columns(stack.yaw_rate, settings.gamma)
        model, curve = trained(settings, stack, fastest, memory.noise, warm=warm, phi=phi)
        active = np.flatnonzero(np.abs(model.weight) > 1e-9 * settings.C)  # the others are zero
        wild = outliers(curve[active] - stack.damping[active])
        left, removed = active[~wild], stack.take(active[wild])
        stays = forgetting(settings, stack.yaw_rate[left])
        kept, weight = left[stays], model.weight
        model, _ = trained(settings, stack.take(kept), fastest, memory.noise, warm=weight[kept], phi=phi[:, kept])
        noise = memory.noise.after(batch.damping - model.learned(batch), place, batch.yaw_rate)
        vectors = stack.take(left)
        memory = Memory(vectors.time, vectors.yaw_rate, vectors.damping, stays, noise, weight[left])
    return memory, Iteration(
        number=number,
        trained=len(new) > 0,
        old=old,
        new=new,
        support=memory.served,
        forgotten=forgotten,
        discarded_tube=batch.take(verdict.in_tube),
        discarded_near=batch.take(verdict.near),
        outliers=removed,
        model=model,
    )


class Inclusion(NamedTuple):
    """The fate of each new sample; exactly one of the three masks (n,) holds for each."""

    kept: Mask
    in_tube: Mask
    near: Mask


def inclusion(
    settings: Settings,
    rate: Array,
    damping: Array,
    predicted: Array | None,
    support_rate: Array,
    support_damping: Array,
) -> Inclusion:
    """Inclusion (Section III-C 1): a new sample that tells the model nothing new is discarded.

    It does where |f(x) − y| < ε, or where a vector has |Δx| < a and |Δy| < b.

    Args:
        rate, damping: (n,) of the new samples [rad/s], [N m].
        predicted: (n,) f(x) of the model so far [N m]; None while nothing is learned: then no tube holds a sample.
        support_rate, support_damping: (m,) of the support vectors [rad/s], [N m].
    """
    in_tube = np.zeros(damping.size, dtype=bool)
    if predicted is not None:
        in_tube = np.abs(predicted - damping) < settings.epsilon
    beside = np.abs(damping[:, None] - support_damping) < settings.near_damping
    beside &= np.abs(rate[:, None] - support_rate) < settings.near_rate
    near_one = beside.any(axis=1) & ~in_tube
    return Inclusion(~(in_tube | near_one), in_tube, near_one)


def forgetting(settings: Settings, rate: Array) -> Mask:
    """Forgetting (Section III-C 2): the oldest of the fullest bin goes, until `capacity` are left.

    The bins are equal and span `rate_range`; what lies outside falls into the first or the last.

    Args:
        rate: (n,) yaw rates of the support vectors [rad/s], oldest first.

    Returns:
        (n,) mask of those that stay. Of equally full bins the one that holds the oldest vector gives it up.
    """
    n, capacity, bins = rate.size, settings.capacity, settings.bins
    if n <= capacity:
        return np.ones(n, dtype=bool)
    low, high = settings.rate_range
    place = np.clip((rate - low) * (bins / (high - low)), 0, bins - 1).astype(np.intp)
    # One by one the oldest of the fullest bin: what stays are the vectors with the fewest newer ones in their bin, and
    # of equals the newest.
    by_bin = np.argsort(place[::-1], kind="stable")
    sizes = np.bincount(place, minlength=bins)
    newer = np.arange(n) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    age = np.empty(n, dtype=np.intp)
    age[by_bin] = newer * n
    age += np.arange(n)
    stays = np.zeros(n, dtype=bool)
    stays[n - 1 - np.argpartition(age, capacity - 1)[:capacity]] = True
    return stays
