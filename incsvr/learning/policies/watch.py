"""Watching for a change of the vehicle: transport of what is learned, and probation.

When the evidence says that the curve has moved (change.py), every vector moves by the correction g(x)
and keeps only as much information as the correction is certain. That is a guess from some fifty samples, so for
PROBATION_BATCHES batches it is on probation: each batch corrects the correction, and the vectors from before come
back if they explain the batches since better than the corrected ones with all their doubt.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from incsvr.learning.iteration import Settings
from incsvr.learning.model import Model
from incsvr.learning.policies.change import (
    ALARM_LOG_ODDS,
    WINDOW_BATCHES,
    Evidence,
    features,
    gather,
    prior,
    surprise,
    weigh,
)
from incsvr.learning.policies.merging import Vectors
from incsvr.learning.policies.noise import Noise
from incsvr.numerics import Array

PROBATION_BATCHES = 4
"""Batches for which a correction is on probation."""
VECTORS_PER_FREEDOM = 10.0
"""Vectors that share one degree of freedom of a correction, about: 60 over six. Their doubts are the same doubt."""
YOUNG_CURVE_BATCHES = 3
"""Batches after which the curve is known well enough to be found changed."""


@dataclass(frozen=True, slots=True)
class Probation:
    """A correction that may still turn out wrong."""

    precision: Array  # (p, p) of what is left to correct
    batches: int  # for how many more
    vectors: Vectors  # from before the correction
    model: Model
    held: Array  # (p, p) M + D of them
    lead: float = 0.0  # ln of how much better they explain the batches since


@dataclass(frozen=True, slots=True)
class Watch:
    """The memory between two batches."""

    seen: int = 0  # batches so far, as far as they count
    recent: tuple[Evidence, ...] = ()  # evidence of the last batches, oldest first, since the last correction
    probation: Probation | None = None  # of the last correction, while it lasts


def follow(
    settings: Settings,
    watch: Watch,
    vectors: Vectors,
    model: Model,
    noise: Noise,
    rate: Array,
    damping: Array,
    predicted: Array,
    index: NDArray[np.intp],
) -> tuple[Vectors, Watch, str | None]:
    """The vectors, moved or put back where the evidence says so, and a sentence when it does.

    Args:
        vectors, model, noise: as they were before the batch.
        rate, damping: (n,) of the batch's samples without outliers [rad/s], [N m].
        predicted: (n,) f(x) of these samples under `model` [N m].
        index: (n,) their places in the stream.
    """
    points, probation, sentence = vectors.points, watch.probation, None
    # Both curves are judged by the same samples: those at rates that both knew.
    known = points.yaw_rate if probation is None else probation.vectors.points.yaw_rate
    inside = (rate >= known[0]) & (rate <= known[-1])
    rate, damping, now, index = rate[inside], damping[inside], predicted[inside], index[inside]
    fresh = gather(rate, _features(settings, rate, now), damping - now, index, noise)
    if probation is not None:
        then = probation.model.evaluate(rate)
        before = gather(rate, _features(settings, rate, then), damping - then, index, noise)
        lead = probation.lead + surprise(fresh, probation.precision) - surprise(before, probation.held)
        if lead > ALARM_LOG_ODDS:
            sentence = f"the damping is as it was before the last change (ln Bayes factor {lead:.1f})"
            vectors, model, fresh, probation = probation.vectors, probation.model, before, None
            points = vectors.points
        else:
            probation = replace(probation, lead=lead)

    seen = min(watch.seen + 1, YOUNG_CURVE_BATCHES)
    recent = (*watch.recent, fresh)[-WINDOW_BATCHES[-1] :]
    free = prior(noise.sigma)
    at_vectors = _features(settings, points.yaw_rate, model.at_support)
    held = (at_vectors.T * (vectors.information * noise.worth)) @ at_vectors + free
    log_factor, evidence = weigh(recent, held, free)
    changed = log_factor > ALARM_LOG_ODDS and seen >= YOUNG_CURVE_BATCHES
    if changed:
        precision = free + evidence.information
    elif probation is not None:
        evidence, precision = fresh, probation.precision + fresh.information
    else:
        return vectors, Watch(seen, recent), sentence

    at_vectors, correction = _correction(settings, points.yaw_rate, model, evidence, precision)
    moved = replace(vectors, points=replace(points, damping=points.damping + correction))
    if changed:
        doubt = VECTORS_PER_FREEDOM * noise.worth * _variance(at_vectors, precision)
        moved = replace(moved, information=1.0 / (1.0 / vectors.information + doubt))
        probation = Probation(precision, PROBATION_BATCHES, vectors, model, held)
        sentence = _sentence(correction, at_vectors[:, 0], log_factor)
        return moved, Watch(seen, (), probation), sentence
    assert probation is not None
    probation = replace(probation, precision=precision, batches=probation.batches - 1)
    return moved, Watch(seen, (), probation if probation.batches else None), None


def _features(settings: Settings, rate: Array, curve: Array) -> Array:
    """(n, p) features of a correction at (n,) rates [rad/s] at which the curve is `curve` (n,) [N m]."""
    low, high = settings.rate_range
    return features((2.0 * rate - low - high) / (high - low), curve)


def _correction(
    settings: Settings, rate: Array, model: Model, evidence: Evidence, precision: Array
) -> tuple[Array, Array]:
    """The features (n, p) of a correction of a model at (n,) rates, and the correction (n,) [N m].

    It is not trusted beyond the largest rate that showed it: from there on it stays as it is.
    """
    reached = np.clip(rate, -evidence.reach, evidence.reach)
    phi = _features(settings, reached, model.evaluate(reached))
    return phi, phi @ np.linalg.solve(precision, evidence.score)


def _variance(phi: Array, precision: Array) -> Array:
    """(n,) variance of a correction of this precision (p, p) where its features are phi (n, p) [N² m²]."""
    return np.asarray((phi * np.linalg.solve(precision, phi.T).T).sum(axis=1))


def _sentence(correction: Array, curve: Array, log_factor: float) -> str:
    """The change as people read it: a correction (n,) of a curve (n,) [N m], and how sure it is."""
    gain = 100.0 * float(correction @ curve) / max(float(curve @ curve), 1e-300)
    return f"the damping has changed by about {gain:+.0f} % (ln Bayes factor {log_factor:.1f})"
