"""The weighted policy: vectors that stand for all samples around them, and a curve that moves when the vehicle changes.

The paper keeps at most 60 raw samples, and what it forgets is lost. Here a vector is the mean of up to
`MAX_VECTOR_SAMPLES` samples and weighs as many: Cᵢ = C nᵢ, and a tube as wide as the noise of its mean, εᵢ = max(ε,
TUBE_DEVIATIONS σ/√nᵢ).

1. Outliers: 1.5 IQR on what the curve leaves over of the new batch, where that is beyond the noise as well, where the
   curve has been trained, and where the batch itself does not say the same at the rates beside it: what came first has
   no privilege, and many samples that disagree alike are a change.
2. Change (watch.py): where a smooth correction of the curve is likelier than the curve, all vectors
   move by it. Only samples at rates where the curve has been trained are asked.
3. Inclusion: a sample joins the vector beside it or becomes one.
4. Forgetting: while there are more than `capacity`, the two closest neighbours become one.
5. Training on what is kept, and that is served.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from incsvr.learning.criteria import outliers
from incsvr.learning.iteration import Iteration, Settings, train
from incsvr.learning.model import Model
from incsvr.learning.policies.merging import Vectors
from incsvr.learning.policies.noise import Noise
from incsvr.learning.policies.watch import Watch, follow
from incsvr.learning.windows import windows
from incsvr.numerics import Array
from incsvr.signals.samples import Samples

MAX_VECTOR_SAMPLES = 15.0
"""Samples that a vector stands for, at most."""
JOINING_RADIUS = 0.7
"""Distance within which a sample joins a vector, in mean distances of `capacity` vectors over the rate range."""
TUBE_DEVIATIONS = 0.3
"""Half height of a vector's tube, in standard deviations of its mean."""
MIN_OUTLIER_NOISES = 2.5
"""Noise levels that an outlier is away at least: where a batch hardly varies, its quartiles say little."""
MIN_TRAINED_SAMPLES = 4.5
"""Samples near a rate from which on the curve is trained there: the mean of five is twice as sure as one. (Half a
sample less, so that rounding decides nothing.)"""
NEAR_RADII = 3.0
"""Reach of "near", in radii within which a sample joins a vector."""
NEIGHBOUR_SAMPLES = 7
"""Samples of the batch, next to each other in rate, whose median says what the batch itself means there."""


@dataclass(frozen=True, slots=True)
class Memory:
    """What the weighted policy carries from one iteration to the next.

    Attributes:
        vectors: at most `capacity`.
        noise: of the samples.
        watch: for changes of the vehicle.
    """

    vectors: Vectors
    noise: Noise
    watch: Watch

    @property
    def served(self) -> Samples:
        """The vectors of the served model."""
        return self.vectors.points

    def to_dict(self) -> dict[str, Any]:
        return {
            "vectors": self.vectors.to_dict(),
            "noise": self.noise.to_dict(),
            "watch": self.watch.to_dict(),
        }

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> Memory:
        return Memory(
            Vectors.from_dict(data["vectors"]), Noise.from_dict(data["noise"]), Watch.from_dict(data["watch"])
        )


def start(settings: Settings) -> Memory:
    return Memory(Vectors.empty(), Noise.start(settings.rate_range), Watch())


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
    vectors, noise, watch, change = memory.vectors, memory.noise, memory.watch, None
    low, high = settings.rate_range
    radius = JOINING_RADIUS * (high - low) / settings.capacity
    if predicted is None:
        # There is no curve yet by which to call a sample an outlier, only the batch's own.
        wild = np.zeros(len(batch), dtype=bool)
        own = _served(settings, Vectors.of(batch, information=1.0), noise)
        noise = noise.after(batch.damping - own.evaluate(batch.yaw_rate), place, batch.yaw_rate)
        kept = batch
    else:
        residual = batch.damping - predicted
        trained = vectors.within(batch.yaw_rate, NEAR_RADII * radius) * noise.variance >= MIN_TRAINED_SAMPLES
        alone = np.minimum(np.abs(residual), np.abs(residual - _beside(batch.yaw_rate, residual)))
        spread = noise.spread.at(batch.yaw_rate)  # where the noise is loud, far is farther
        wild = outliers(residual / spread) & trained & (alone > MIN_OUTLIER_NOISES * noise.sigma * spread)
        index = np.flatnonzero(~wild)
        kept, residual, trained, place = batch.take(index), residual[index], trained[index], place[index]
        # Between two turns that were held the curve has guessed: that it guessed wrongly is no change.
        vectors, watch, change = follow(
            settings, watch, vectors, model, noise, kept.take(trained), predicted[index][trained], place[trained]
        )
    each = 1.0 / noise.variance
    included = vectors.absorb(kept, radius=radius, each=each, most=MAX_VECTOR_SAMPLES * each)
    vectors = included.condense(settings.capacity, most=MAX_VECTOR_SAMPLES * each)
    served = _served(settings, vectors, noise)
    if predicted is not None:
        # A curve tells the noise of what it has not seen, but not where it was never trained, or has moved since.
        told = trained & (change is None)
        left = np.where(told, residual, kept.damping - served.evaluate(kept.yaw_rate))
        noise = noise.after(left, place, kept.yaw_rate)
    return Memory(vectors, noise, watch), Iteration(
        number=number,
        time_span=(float(batch.time[0]), float(batch.time[-1])),
        trained=True,
        old=memory.vectors.points,
        new=kept,
        support=vectors.points,
        forgotten=included.without(vectors),
        discarded_tube=Samples.empty(),
        discarded_near=Samples.empty(),
        outliers=batch.take(wild),
        model=served,
        change=change,
    )


def _served(settings: Settings, vectors: Vectors, noise: Noise) -> Model:
    """The model on these vectors: Cᵢ = C nᵢ and εᵢ = max(ε, TUBE_DEVIATIONS σ/√nᵢ) with nᵢ samples of today's noise
    in each."""
    points = vectors.points
    count = vectors.information * noise.variance
    tube = np.maximum(settings.epsilon, TUBE_DEVIATIONS / np.sqrt(vectors.information)) if noise.seen else None
    solution = train(settings, points.yaw_rate, points.damping, C=settings.C * count, epsilon=tube)
    return Model(
        settings.gamma,
        settings.C,
        settings.epsilon,
        support_rate=points.yaw_rate,
        support_damping=points.damping,
        weight=solution.weight,
        count=count,
        sigma=noise.sigma,
        certified_error=solution.certified_error,
    )


def _beside(rate: Array, residual: Array) -> Array:
    """(n,) the median residual [N m] of the NEIGHBOUR_SAMPLES samples of the batch around each in yaw rate."""
    order = rate.argsort(kind="stable")
    width = min(NEIGHBOUR_SAMPLES, rate.size)
    ordered = np.sort(windows(residual[order], width), axis=1)
    around = np.empty(rate.size)
    around[order] = 0.5 * (ordered[:, (width - 1) // 2] + ordered[:, width // 2])
    return around
