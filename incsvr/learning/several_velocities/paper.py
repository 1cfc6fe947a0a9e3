"""The paper's policy over several velocities: inclusion → forgetting → stack → train → outlier removal.

As over one (policies/paper.py), with three differences: a vector is near where it is near in every velocity, the
forgetting goes by a density in place of bins, and what the kernels learn is what the textbook's drag leaves over.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from incsvr.learning.criteria import Inclusion, Mask, outliers
from incsvr.learning.iteration import Iteration, Settings
from incsvr.learning.model import Model
from incsvr.learning.policies.noise import Noise
from incsvr.learning.several_velocities.density import forgetting
from incsvr.learning.several_velocities.training import fastest_of, model_of, train
from incsvr.learning.several_velocities.velocities import points
from incsvr.numerics import Array
from incsvr.signals.samples import Samples

MIN_WEIGHT_SHARE = 1e-9
"""Share of C below which a weight is zero."""


@dataclass(frozen=True, slots=True)
class Memory:
    """What the policy carries from one iteration to the next.

    Attributes:
        vectors: (n,) support vectors after outlier removal, oldest first, with their further velocities.
        stays: (n,) those that the next iteration's forgetting keeps: what is served.
        fastest: (d − 1,) of each further velocity so far, in its unit.
        noise: of the samples about the curve.
    """

    vectors: Samples
    stays: Mask
    fastest: Array
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
            "others": {name: values.tolist() for name, values in self.vectors.channels.items()},
            "stays": self.stays.tolist(),
            "fastest": self.fastest.tolist(),
            "noise": self.noise.to_dict(),
        }

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> Memory:
        time, rate, damping, fastest = (
            np.array(data[name], dtype=np.float64) for name in ("time", "yaw_rate", "damping", "fastest")
        )
        others = {name: np.array(values, dtype=np.float64) for name, values in data["others"].items()}
        stays = np.array(data["stays"], dtype=np.bool_)
        return Memory(Samples(time, rate, damping, others), stays, fastest, Noise.from_dict(data["noise"]))


def start(settings: Settings) -> Memory:
    nothing = np.empty(0)
    vectors = Samples(nothing, nothing, nothing, dict.fromkeys(settings.others, nothing))
    return Memory(
        vectors, np.empty(0, dtype=np.bool_), np.zeros(len(settings.others)), Noise.start(settings.rate_range)
    )


def learn(
    settings: Settings,
    number: int,
    memory: Memory,
    model: Model,
    batch: Samples,
    predicted: Array | None,
    place: NDArray[np.intp],
) -> tuple[Memory, Iteration]:
    """Iteration `number` with a `batch` of n ≥ 1 samples; as `policies.paper.learn`."""
    before, stays = memory.vectors, memory.stays
    fastest = fastest_of(settings, memory.fastest, batch)
    verdict = _inclusion(settings, batch, predicted, before, fastest)
    old, new = before.take(stays), batch.take(verdict.kept)
    forgotten, removed = before.take(~stays), Samples.empty()
    if len(new):
        stack = Samples.concatenate((old, new))
        trained = train(settings, stack, fastest, memory.noise)
        active = np.abs(trained.solution.weight) > MIN_WEIGHT_SHARE * settings.C
        support = stack.take(active)
        wild = outliers(trained.fitted[active] - support.damping)
        removed = support.take(wild)
        vectors = support.take(~wild)
        stays = forgetting(points(vectors, settings.others) / fastest, capacity=settings.capacity)
        memory = Memory(vectors, stays, fastest[1:], memory.noise)
        model = model_of(settings, memory.served, fastest, memory.noise)
        noise = memory.noise.after(batch.damping - model.learned(batch), place, batch.yaw_rate)
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


def _inclusion(
    settings: Settings, batch: Samples, predicted: Array | None, before: Samples, fastest: Array
) -> Inclusion:
    """Inclusion (Section III-C 1) with a distance for each velocity."""
    silent = np.zeros(len(batch), dtype=bool)
    in_tube = silent if predicted is None else np.abs(predicted - batch.damping) < settings.epsilon
    beside = np.abs(batch.damping[:, None] - before.damping) < settings.near_damping
    new, known = points(batch, settings.others), points(before, settings.others)
    for column, near in enumerate(near_distances(settings, fastest)):
        beside &= np.abs(new[:, column, None] - known[:, column]) < near
    near_one = beside.any(axis=1) & ~in_tube
    return Inclusion(~(in_tube | near_one), in_tube, near_one)


def near_distances(settings: Settings, fastest: Array) -> list[float]:
    """a of each velocity in its unit: as configured, or the own one's as a part of the fastest."""
    part = settings.near_rate / float(fastest[0])
    further = zip(settings.others, fastest[1:].tolist(), strict=True)
    return [settings.near_rate, *(settings.near.get(name, part * each) for name, each in further)]
