"""The weighted policy over several velocities: vectors that stand for all samples around them.

As over one (policies/weighted.py), but that a change of the vehicle is not sought: a vector stands for the newest
MAX_VECTOR_SAMPLES samples around it and moves on with them.

1. Outliers: 1.5 IQR on what the surface leaves over of the new batch, where that is beyond the noise as well and where
   the surface has been trained.
2. Inclusion: a sample joins the nearest vector, where that is near, or becomes one.
3. Forgetting: while there are more than `capacity`, the two closest vectors become one.
4. Training on what is kept, and that is served.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from incsvr.learning.criteria import outliers
from incsvr.learning.iteration import Iteration, Settings
from incsvr.learning.model import Model
from incsvr.learning.policies.noise import Noise
from incsvr.learning.policies.weighted import (
    JOINING_RADIUS,
    MAX_VECTOR_SAMPLES,
    MIN_OUTLIER_NOISES,
    MIN_TRAINED_SAMPLES,
    NEAR_RADII,
    TUBE_DEVIATIONS,
)
from incsvr.learning.several_velocities.merging import Vectors
from incsvr.learning.several_velocities.training import fastest_of, model_of
from incsvr.learning.several_velocities.velocities import points
from incsvr.numerics import Array
from incsvr.signals.samples import Samples


@dataclass(frozen=True, slots=True)
class Memory:
    """What the policy carries from one iteration to the next.

    Attributes:
        vectors: at most `capacity`.
        fastest: (d − 1,) of each further velocity so far, in its unit.
        noise: of the samples.
    """

    vectors: Vectors
    fastest: Array
    noise: Noise

    @property
    def served(self) -> Samples:
        """The vectors of the served model."""
        return self.vectors.points

    def to_dict(self) -> dict[str, Any]:
        return {
            "vectors": self.vectors.to_dict(),
            "fastest": self.fastest.tolist(),
            "noise": self.noise.to_dict(),
        }

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> Memory:
        return Memory(Vectors.from_dict(data["vectors"]), np.array(data["fastest"]), Noise.from_dict(data["noise"]))


def start(settings: Settings) -> Memory:
    return Memory(
        Vectors.empty(settings.own, settings.others), np.zeros(len(settings.others)), Noise.start(settings.rate_range)
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
    """Iteration `number` with a `batch` of n ≥ 1 samples; as `policies.weighted.learn`."""
    vectors, noise = memory.vectors, memory.noise
    fastest = fastest_of(settings, memory.fastest, batch)
    radius = radius_of(settings.capacity, 1 + len(settings.others))
    if predicted is None:
        # There is no surface yet by which to call a sample an outlier, only the batch's own.
        wild = np.zeros(len(batch), dtype=bool)
        own = _served(settings, Vectors.of(settings.own, settings.others, batch, 1.0), fastest, noise)
        noise = noise.after(batch.damping - own.learned(batch), place, batch.yaw_rate)
        kept = batch
    else:
        residual, spread = batch.damping - predicted, noise.spread.at(batch.yaw_rate)
        u = points(batch, settings.others) / fastest
        trained = vectors.within(u, fastest, NEAR_RADII * radius) * noise.variance >= MIN_TRAINED_SAMPLES
        wild = outliers(residual / spread) & trained & (np.abs(residual) > MIN_OUTLIER_NOISES * noise.sigma * spread)
        kept, residual, trained, place = batch.take(~wild), residual[~wild], trained[~wild], place[~wild]
    each = 1.0 / noise.variance
    included = vectors.absorb(kept, fastest, radius, each=each, most=MAX_VECTOR_SAMPLES * each)
    vectors = included.condense(fastest, settings.capacity, most=MAX_VECTOR_SAMPLES * each)
    served = _served(settings, vectors, fastest, noise)
    if predicted is not None:
        # A surface tells the noise of what it has not seen, but not where it was never trained.
        left = np.where(trained, residual, kept.damping - served.learned(kept))
        noise = noise.after(left, place, kept.yaw_rate)
    nothing = batch.take(slice(0, 0))
    return Memory(vectors, fastest[1:], noise), Iteration(
        number=number,
        time_span=(float(batch.time[0]), float(batch.time[-1])),
        trained=True,
        old=memory.vectors.points,
        new=kept,
        support=vectors.points,
        forgotten=included.without(vectors),
        discarded_tube=nothing,
        discarded_near=nothing,
        outliers=batch.take(wild),
        model=served,
    )


def radius_of(capacity: int, d: int) -> float:
    """Distance within which a sample joins a vector, in fastest velocities: JOINING_RADIUS mean distances of `capacity`
    vectors that fill a cube from −1 to 1 of d dimensions."""
    return float(JOINING_RADIUS * 2.0 * capacity ** (-1.0 / d))


def _served(settings: Settings, vectors: Vectors, fastest: Array, noise: Noise) -> Model:
    """The model on these vectors: Cᵢ = C nᵢ and εᵢ = max(ε, TUBE_DEVIATIONS σ/√nᵢ) with nᵢ samples of today's noise
    in each."""
    count = vectors.information * noise.variance
    tube = np.maximum(settings.epsilon, TUBE_DEVIATIONS / np.sqrt(vectors.information)) if noise.seen else None
    return model_of(settings, vectors.points, fastest, noise, count, tube, vectors.terms)
