"""The paper's policy, to the letter (Fig. 3): inclusion → forgetting → stack → train → outlier removal.

The vectors and weights that the outlier removal leaves are carried into the next iteration, where the weights warm
Eq. 8's passes. They are not what is served. Every θ is near ±C and every kernel spans most of the range, so a sum from
which vectors have been struck out is off by thousands of N m: what is served is solved again on the vectors that the
next iteration's forgetting will keep, at most `capacity` of them.

It learns over one velocity, as the paper does.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from incsvr.learning.criteria import Mask, forgetting, inclusion, outliers
from incsvr.learning.iteration import Iteration, Settings
from incsvr.learning.kernel import columns
from incsvr.learning.model import Model
from incsvr.learning.plain_samples import columns_to_dict, samples_from_dict
from incsvr.learning.policies.noise import Noise
from incsvr.learning.policies.training import fastest_of, trained
from incsvr.numerics import Array
from incsvr.numerics.plain import from_plain, to_plain
from incsvr.signals.samples import Samples

MIN_WEIGHT_SHARE = 1e-9
"""Share of C below which a weight is zero."""


@dataclass(frozen=True, eq=False)
class Memory:
    """The memory of the paper's policy between two iterations."""

    vectors: Samples  # (n,) support vectors after outlier removal, oldest first, n ≤ capacity + batch
    weight: Array  # (n,) their θ [N m]
    stays: Mask  # (n,) those that the next iteration's forgetting keeps: what is served
    noise: Noise  # of the samples about the curve

    @cached_property
    def served(self) -> Samples:
        """The vectors of the served model."""
        return self.vectors.take(self.stays)

    @property
    def fastest(self) -> Array:
        """(d − 1,) of each further velocity: zero, as before anything was driven."""
        return np.zeros(len(self.vectors.channels))

    def to_dict(self) -> dict[str, Any]:
        return {
            **columns_to_dict(self.vectors),
            "weight": self.weight.tolist(),
            "stays": self.stays.tolist(),
            "noise": to_plain(self.noise),
        }

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> Memory:
        vectors = samples_from_dict(data)
        # a state over several velocities lacks the weights; `weighted` goes on from its vectors
        weight = np.array(data.get("weight", np.zeros(len(vectors))), dtype=np.float64)
        return Memory(vectors, weight, np.array(data["stays"], dtype=np.bool_), from_plain(Noise, data["noise"]))


def start(settings: Settings) -> Memory:
    nothing = np.empty(0)
    vectors = Samples(nothing, nothing, nothing)
    return Memory(vectors, nothing, np.empty(0, dtype=np.bool_), Noise.start(settings.rate_range))


def continued(settings: Settings, other: Any) -> Memory:
    """The memory that goes on from another policy's: its vectors as samples, one each."""
    vectors = other.served
    return Memory(vectors, np.zeros(len(vectors)), np.ones(len(vectors), dtype=np.bool_), other.noise)


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
    before, stays = memory.vectors, memory.stays
    fastest = fastest_of(settings, memory.fastest, batch)
    verdict = inclusion(
        batch.yaw_rate,
        batch.damping,
        predicted,
        before.yaw_rate,
        before.damping,
        epsilon=settings.epsilon,
        near_rate=settings.near_rate,
        near_damping=settings.near_damping,
    )
    old, new = memory.served, batch.take(verdict.kept)
    # Where no training takes place, nothing has to make room.
    forgotten, removed = before.take(~stays) if len(new) else Samples.empty(), Samples.empty()
    if len(new):
        stack = Samples.concatenate((old, new))
        warm = np.concatenate((memory.weight[stays], np.zeros(len(new))))
        phi = columns(stack.yaw_rate, settings.gamma)
        model, curve = trained(settings, stack, fastest, memory.noise, warm=warm, phi=phi)
        active = np.flatnonzero(np.abs(model.weight) > MIN_WEIGHT_SHARE * settings.C)
        wild = outliers(curve[active] - stack.damping[active])
        left, removed = active[~wild], stack.take(active[wild])
        vectors, weight = stack.take(left), model.weight[left]
        rate_range = settings.rate_range
        stays = forgetting(vectors.yaw_rate, capacity=settings.capacity, bins=settings.bins, rate_range=rate_range)
        served, phi = vectors.take(stays), phi[:, left[stays]]
        model, _ = trained(settings, served, fastest, memory.noise, warm=weight[stays], phi=phi)
        noise = memory.noise.after(batch.damping - model.learned(batch), place, batch.yaw_rate)
        memory = Memory(vectors, weight, stays, noise)
    return memory, Iteration(
        number=number,
        time_span=(float(batch.time[0]), float(batch.time[-1])),
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
