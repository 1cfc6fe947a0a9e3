"""The paper's policy, to the letter (Fig. 3): inclusion → forgetting → stack → train → outlier removal.

The vectors and weights that the outlier removal leaves are carried into the next iteration, where the weights warm
Eq. 8's passes. They are not what is served. Every θ is near ±C and every kernel spans most of the range, so a sum from
which vectors have been struck out is off by thousands of N m: what is served is solved again on the vectors that the
next iteration's forgetting will keep, at most `capacity` of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from incsvr.learning.criteria import Mask, forgetting, inclusion, outliers
from incsvr.learning.iteration import Iteration, Settings, train
from incsvr.learning.model import Model
from incsvr.learning.policies.noise import Noise
from incsvr.numerics import Array
from incsvr.signals.samples import Samples

MIN_WEIGHT_SHARE = 1e-9
"""Share of C below which a weight is zero."""


@dataclass(frozen=True, slots=True)
class Memory:
    """What the paper's policy carries from one iteration to the next.

    Attributes:
        vectors: (n,) support vectors after outlier removal, oldest first, n ≤ capacity + batch.
        weight: (n,) their θ [N m].
        stays: (n,) those that the next iteration's forgetting keeps: what is served.
        noise: of the samples about the curve.
    """

    vectors: Samples
    weight: Array
    stays: Mask
    noise: Noise

    @property
    def served(self) -> Samples:
        """The vectors of the served model."""
        return self.vectors.take(self.stays)

    def to_dict(self) -> dict[str, Any]:
        return {
            "time": self.vectors.time.tolist(),
            "yaw_rate": self.vectors.yaw_rate.tolist(),
            "damping": self.vectors.damping.tolist(),
            "weight": self.weight.tolist(),
            "stays": self.stays.tolist(),
            "noise": self.noise.to_dict(),
        }

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> Memory:
        time, rate, damping, weight = (
            np.array(data[name], dtype=np.float64) for name in ("time", "yaw_rate", "damping", "weight")
        )
        stays = np.array(data["stays"], dtype=np.bool_)
        return Memory(Samples(time, rate, damping), weight, stays, Noise.from_dict(data["noise"]))


def start(settings: Settings) -> Memory:
    return Memory(Samples.empty(), np.empty(0), np.empty(0, dtype=np.bool_), Noise.start(settings.rate_range))


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
    before = memory.vectors
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
    stays = memory.stays
    old, new = before.take(stays), batch.take(verdict.kept)
    forgotten, removed = before.take(~stays), Samples.empty()
    if len(new):
        stack = Samples.concatenate((old, new))
        warm = np.concatenate((memory.weight[stays], np.zeros(len(new))))
        trained = train(settings, stack.yaw_rate, stack.damping, start=warm)
        active = np.abs(trained.weight) > MIN_WEIGHT_SHARE * settings.C
        support, weight = stack.take(active), trained.weight[active]
        wild = outliers(trained.fitted[active] - support.damping)
        removed = support.take(wild)
        vectors = support.take(~wild)
        stays = forgetting(
            vectors.yaw_rate, capacity=settings.capacity, bins=settings.bins, rate_range=settings.rate_range
        )
        memory = Memory(vectors, weight[~wild], stays, memory.noise)
        model = _served(settings, memory)
        noise = memory.noise.after(batch.damping - model.evaluate(batch.yaw_rate), place, batch.yaw_rate)
        memory = replace(memory, noise=noise)
    else:
        forgotten = Samples.empty()  # no training takes place, so nothing has to make room
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


def _served(settings: Settings, memory: Memory) -> Model:
    """The model on the vectors that the next forgetting will keep, solved again on just these."""
    vectors = memory.served
    solution = train(settings, vectors.yaw_rate, vectors.damping, start=memory.weight[memory.stays])
    return Model(
        settings.gamma,
        settings.C,
        settings.epsilon,
        support_rate=vectors.yaw_rate,
        support_damping=vectors.damping,
        weight=solution.weight,
        count=np.ones(len(vectors)),
        sigma=memory.noise.sigma,
        certified_error=solution.certified_error,
    )
