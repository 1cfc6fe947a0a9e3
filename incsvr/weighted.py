"""The weighted policy: vectors that stand for all samples around them, and a curve that moves when the vehicle changes.

The paper keeps at most 60 raw samples, and what it forgets is lost. Here a vector is the mean of up to `MOST` samples
and weighs as many: Cᵢ = C nᵢ, and a tube as wide as the noise of its mean, εᵢ = max(ε, TUBE σ/√nᵢ).

1. Outliers: 1.5 IQR on what the curve leaves over of the new batch.
2. Change (incsvr/change.py): is a smooth correction of the curve likelier than the curve itself? Then all vectors move
   by it, and each keeps only as much weight as the correction is certain. For OPEN further batches it stays open: every
   batch corrects the correction, so a mistaken one is taken back.
3. Inclusion: a sample joins the vector beside it or becomes one.
4. Forgetting: while there are more than `capacity`, the two closest neighbours become one.
5. Training on what is kept, and that is served.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from incsvr.change import ALARM, WINDOWS, Evidence, features, gather, prior, weigh
from incsvr.criteria import outliers
from incsvr.iteration import Iteration, Settings, train
from incsvr.merging import Vectors
from incsvr.model import Model
from incsvr.noise import Noise
from incsvr.samples import Array, Samples

MOST = 15.0
"""Samples that a vector stands for, at most."""
RADIUS = 0.7
"""Within which a sample joins a vector, in mean distances of `capacity` vectors over the rate range."""
TUBE = 0.6
"""Half height of a vector's tube, in standard deviations of its mean."""
OPEN = 4
"""Batches for which a correction stays open."""
SHARED = 10.0
"""Vectors that share one degree of freedom of the correction: 60 over about six."""
FIRST_TEST = 4
"""Iteration from which on the curve is known well enough to be found changed."""


@dataclass(frozen=True, slots=True)
class Memory:
    """What the weighted policy carries from one iteration to the next.

    Attributes:
        vectors: at most `capacity`.
        noise: of the samples.
        recent: evidence for a change in the last batches.
        correction: the last correction's precision (p, p) while it is open.
        open: for how many more batches.
    """

    vectors: Vectors
    noise: Noise
    recent: tuple[Evidence, ...]
    correction: Array | None
    open: int

    def to_dict(self) -> dict[str, Any]:
        points = self.vectors.points
        return {
            "time": points.time.tolist(),
            "yaw_rate": points.yaw_rate.tolist(),
            "damping": points.damping.tolist(),
            "information": self.vectors.information.tolist(),
            "noise": self.noise.to_list(),
            "recent": [part.to_dict() for part in self.recent],
            "correction": None if self.correction is None else self.correction.tolist(),
            "open": self.open,
        }

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> Memory:
        time, rate, damping, information = (
            np.array(data[name], dtype=np.float64) for name in ("time", "yaw_rate", "damping", "information")
        )
        return Memory(
            Vectors(Samples(time, rate, damping), information),
            Noise.from_list(data["noise"]),
            tuple(Evidence.from_dict(part) for part in data["recent"]),
            None if data["correction"] is None else np.array(data["correction"]),
            data["open"],
        )


def start(settings: Settings) -> Memory:
    return Memory(Vectors.empty(), Noise(), (), None, 0)


def learn(
    settings: Settings, number: int, memory: Memory, model: Model, batch: Samples, predicted: Array | None
) -> tuple[Memory, Iteration]:
    """Iteration `number` with a `batch` of n ≥ 1 samples.

    Args:
        memory, model: from before.
        predicted: (n,) f(x) of the batch under `model` [N m], None before there is one.
    """
    old = memory.vectors.points
    if predicted is None:
        first = _served(settings, Vectors.of(batch, information=1.0), Noise())
        residual = batch.damping - first.evaluate(batch.yaw_rate)
    else:
        residual = batch.damping - predicted
    wild = outliers(residual)
    index = np.flatnonzero(~wild)
    kept, residual = batch.take(index), residual[index]
    change = None
    if predicted is None:
        memory = replace(memory, noise=memory.noise.after(residual, index))
    else:
        memory, change = _tested(settings, number, memory, model, kept, residual, index)
    each = 1.0 / memory.noise.variance
    low, high = settings.rate_range
    radius = RADIUS * (high - low) / settings.capacity
    included = memory.vectors.absorb(kept, radius=radius, each=each, most=MOST * each)
    vectors = included.condense(settings.capacity, most=MOST * each)
    served = _served(settings, vectors, memory.noise)
    if change:
        residual = kept.damping - served.evaluate(kept.yaw_rate)
    noise = memory.noise if predicted is None else memory.noise.after(residual, index)
    served = replace(served, sigma=noise.sigma)
    return replace(memory, vectors=vectors, noise=noise), Iteration(
        number=number,
        time_span=(float(batch.time[0]), float(batch.time[-1])),
        trained=True,
        old=old,
        new=kept,
        support=vectors.points,
        forgotten=included.points.take(~np.isin(included.points.yaw_rate, vectors.points.yaw_rate)),
        discarded_tube=Samples.empty(),
        discarded_near=Samples.empty(),
        outliers=batch.take(wild),
        model=served,
        progressive_mae=None if predicted is None else float(np.abs(predicted - batch.damping).mean()),
        change=change,
    )


def _tested(
    settings: Settings,
    number: int,
    memory: Memory,
    model: Model,
    batch: Samples,
    residual: Array,
    index: NDArray[np.intp],
) -> tuple[Memory, str | None]:
    """The memory, moved if the vehicle has changed or an earlier correction is still open, and a sentence on a change.

    Args:
        batch: (n,) samples without outliers.
        residual: (n,) y − f(x) [N m].
        index: (n,) their places in the stream.
    """
    vectors, noise, points = memory.vectors, memory.noise, memory.vectors.points
    low, high = settings.rate_range

    def phi(rate: Array) -> Array:
        return features((2.0 * rate - low - high) / (high - low), model.evaluate(rate))

    inside = (batch.yaw_rate >= points.yaw_rate[0]) & (batch.yaw_rate <= points.yaw_rate[-1])
    rate = batch.yaw_rate[inside]
    fresh = gather(rate, phi(rate), residual[inside], index[inside], noise)
    recent = (*memory.recent, fresh)[-WINDOWS[-1] :]
    at_vectors = phi(points.yaw_rate)
    known = (at_vectors.T * (vectors.information * noise.worth)) @ at_vectors
    precision = prior(noise.sigma)
    verdict = weigh(recent, known, precision)
    changed = verdict.log_factor > ALARM and number >= FIRST_TEST
    if changed:
        evidence = verdict.evidence
    elif memory.correction is not None:
        evidence, precision = fresh, memory.correction
    else:
        return replace(memory, recent=recent), None

    # A correction is not trusted beyond the largest rate that showed it: from there on it stays as it is.
    at_vectors = phi(np.clip(points.yaw_rate, -evidence.reach, evidence.reach))
    precision = precision + evidence.information
    correction = at_vectors @ np.linalg.solve(precision, evidence.score)
    moved = replace(vectors, points=replace(points, damping=points.damping + correction))
    if not changed:
        still = memory.open - 1
        return Memory(moved, noise, (), precision if still else None, still), None
    doubt = (at_vectors * np.linalg.solve(precision, at_vectors.T).T).sum(axis=1)
    moved = replace(moved, information=1.0 / (1.0 / vectors.information + SHARED * noise.worth * doubt))
    curve = at_vectors[:, 0]
    gain = float(correction @ curve / (curve @ curve))
    sentence = f"the damping has changed by about {100.0 * gain:+.0f} % (ln Bayes factor {verdict.log_factor:.1f})"
    return Memory(moved, noise, (), precision, OPEN), sentence


def _served(settings: Settings, vectors: Vectors, noise: Noise) -> Model:
    """The model on these vectors: Cᵢ = C nᵢ and εᵢ = max(ε, TUBE σ/√nᵢ) with nᵢ samples of today's noise in each."""
    points = vectors.points
    count = vectors.information * noise.variance
    tube = np.maximum(settings.epsilon, TUBE / np.sqrt(vectors.information)) if noise.seen else None
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
