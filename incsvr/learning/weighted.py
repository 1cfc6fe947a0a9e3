"""The weighted policy: vectors that stand for all samples around them, and a curve that moves when the vehicle changes.

The paper keeps at most 60 raw samples, and what it forgets is lost. Here a vector is the mean of up to
`MAX_VECTOR_SAMPLES` samples and weighs as many: Cᵢ = C nᵢ, and a tube as wide as the noise of its mean, εᵢ = max(ε,
TUBE_DEVIATIONS σ/√nᵢ).

1. Outliers: 1.5 IQR on what the curve leaves over of the new batch, where that is beyond the noise as well, where the
   curve has been trained, and where the batch itself does not say the same at the rates beside it: what came first has
   no privilege, and many samples that disagree alike are a change.
2. Change (change.py): where a smooth correction of the curve is likelier than the curve, all vectors
   move by it. Only samples at rates where the curve has been trained are asked.
3. Inclusion: a sample joins the nearest vector, where that is near, or becomes one.
4. Forgetting: while there are more than `capacity`, the two closest vectors become one.
5. Training on what is kept, and that is served.

Over several velocities no change is sought, and no batch asked what it says itself beside a sample: a vector stands for
the newest `MAX_VECTOR_SAMPLES` samples around it and moves on with them.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from incsvr.learning.change import Watch, follow
from incsvr.learning.driven_motion import windows
from incsvr.learning.iteration import Iteration, Settings
from incsvr.learning.model import Model
from incsvr.learning.noise import Mask, Noise, outliers
from incsvr.learning.training import fastest_of, trained
from incsvr.learning.vectors import Vectors
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
    """The memory of the weighted policy between two iterations."""

    vectors: Vectors  # at most `capacity`
    noise: Noise  # of the samples
    fastest: Array = field(default_factory=lambda: np.empty(0))  # (d − 1,) of each further velocity so far, in its unit
    watch: Watch = field(default_factory=Watch)  # for changes; over several velocities it never sees a batch

    @property
    def served(self) -> Samples:
        """The vectors of the served model."""
        return self.vectors.samples


def start(settings: Settings) -> Memory:
    vectors = Vectors.empty(settings.own, settings.others)
    return Memory(vectors, Noise.start(settings.rate_range), np.zeros(len(settings.others)))


def continued(settings: Settings, other: Any) -> Memory:
    """The memory that goes on from another policy's: its vectors as samples, one each."""
    noise = other.noise
    vectors = Vectors.of(other.served, settings.own, settings.others, information=1.0 / noise.variance)
    return Memory(vectors, noise, other.fastest)


def learn(
    settings: Settings,
    number: int,
    memory: Memory,
    model: Model,
    batch: Samples,
    predicted: Array | None,
    place: NDArray[np.intp],
) -> tuple[Memory, Iteration]:
    """Iteration `number` with a `batch` of n ≥ 1 samples; as `paper.learn`."""
    vectors, noise, watch, change = memory.vectors, memory.noise, memory.watch, None
    fastest, radius = fastest_of(settings, memory.fastest, batch), radius_of(settings)
    wild = np.zeros(len(batch), dtype=bool)
    if predicted is None:
        # There is no curve yet by which to call a sample an outlier, only the batch's own.
        own = _served(settings, Vectors.of(batch, settings.own, settings.others, information=1.0), fastest, noise)
        noise = noise.after(batch.damping - own.learned(batch), place, batch.yaw_rate)
        kept = batch
    else:
        residual = batch.damping - predicted
        known = vectors.within(batch, fastest, NEAR_RADII * radius) * noise.variance >= MIN_TRAINED_SAMPLES
        wild = _wild(settings, noise, batch, residual) & known
        if not settings.others:
            # Between two turns that were held the curve has guessed: that it guessed wrongly is no change.
            at = known & ~wild
            rate, damping = batch.yaw_rate[at], batch.damping[at]
            vectors, watch, change = follow(
                settings, watch, vectors, model, noise, rate, damping, predicted[at], place[at]
            )
        kept = batch
        if wild.any():
            index = np.flatnonzero(~wild)
            kept, residual, known, place = batch.take(index), residual[index], known[index], place[index]
    each = 1.0 / noise.variance
    included = vectors.absorb(kept, fastest, radius, each=each, most=MAX_VECTOR_SAMPLES * each)
    vectors = included.condense(fastest, settings.capacity, most=MAX_VECTOR_SAMPLES * each)
    served = _served(settings, vectors, fastest, noise)
    if predicted is not None:
        # A curve tells the noise of what it has not seen, but not where it was never trained, or has moved since.
        told = known & (change is None)
        left = residual if told.all() else np.where(told, residual, kept.damping - served.learned(kept))
        noise = noise.after(left, place, kept.yaw_rate)
    return Memory(vectors, noise, fastest[1:], watch), Iteration(
        number=number,
        trained=True,
        old=memory.served,
        new=kept,
        support=vectors.samples,
        forgotten=included.without(vectors),
        outliers=batch.take(wild),
        model=served,
        change=change,
    )


def radius_of(settings: Settings) -> float:
    """Distance within which a sample joins a vector, in fastest velocities: JOINING_RADIUS mean distances of `capacity`
    vectors that fill the rate range, or a cube of d dimensions as wide."""
    low, high = settings.rate_range
    width = (high - low) / max(abs(low), abs(high))
    return float(JOINING_RADIUS * width * settings.capacity ** (-1.0 / (1 + len(settings.others))))


def _wild(settings: Settings, noise: Noise, batch: Samples, residual: Array) -> Mask:
    """(n,) the samples of a batch that are outliers by their residual [N m], where the curve has been trained."""
    spread = noise.spread.at(batch.yaw_rate)  # where the noise is loud, far is farther
    alone = np.abs(residual)
    if not settings.others:
        alone = np.minimum(alone, np.abs(residual - _beside(batch.yaw_rate, residual)))
    return outliers(residual / spread) & (alone > MIN_OUTLIER_NOISES * noise.sigma * spread)


def _served(settings: Settings, vectors: Vectors, fastest: Array, noise: Noise) -> Model:
    """The model on these vectors: Cᵢ = C nᵢ and εᵢ = max(ε, TUBE_DEVIATIONS σ/√nᵢ) with nᵢ samples of today's noise
    in each."""
    count = vectors.information * noise.variance
    tube = np.maximum(settings.epsilon, TUBE_DEVIATIONS / np.sqrt(vectors.information)) if noise.seen else None
    return trained(settings, vectors.samples, fastest, noise, count=count, tube=tube, terms=vectors.terms)[0]


def _beside(rate: Array, residual: Array) -> Array:
    """(n,) the median residual [N m] of the NEIGHBOUR_SAMPLES samples of the batch around each in yaw rate."""
    order = rate.argsort(kind="stable")
    width = min(NEIGHBOUR_SAMPLES, rate.size)
    ordered = np.sort(windows(residual[order], width), axis=1)
    around = np.empty(rate.size)
    around[order] = 0.5 * (ordered[:, (width - 1) // 2] + ordered[:, width // 2])
    return around
