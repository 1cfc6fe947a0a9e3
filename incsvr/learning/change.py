"""Has the vehicle changed? A Bayes factor between "what is learned holds" and "the curve has moved smoothly".

What the curve leaves over of a batch, e = y − f(x), may hold a smooth correction g(x) = φ(x)ᵀw: a gain on the curve,
since a new hull scales drag, and Chebyshev polynomials of the yaw rate for all other changes. Whitened for the lag-1
correlation of the noise, some batches say about w only A = Σ φφᵀ/σ² and v = Σ φe/σ². With D, the prior's precision,
and M, what the memory knows in the same form,

    H0, what is learned holds:  w ~ N(0, (M + D)⁻¹)        H1, the curve has moved:  w ~ N(0, D⁻¹)

    −ln p(e) = ½ (eᵀΣ⁻¹e − vᵀ(A + P)⁻¹v + ln |A + P| − ln |P|) + constant,   P = M + D or D,

and the difference of the two is the logarithm of the Bayes factor.
Where the memory knows nothing both say the same, so new territory is no change. Correlation takes evidence away, as it
must (the whitened share of a level shift is 1 − ρ); instead of asking each sample for the rest, as a CUSUM does, the
factor adds it up over the last one, two and four batches. Under H1 the correction is w = (A + D)⁻¹v with covariance
(A + D)⁻¹.

Where the curve has moved, every vector moves by g(x) and keeps only as much information as the correction is certain.
That is a guess from some fifty samples, so for PROBATION_BATCHES batches it is on probation: each batch corrects the
correction, and the vectors from before come back if they explain the batches since better than the corrected ones with
all their doubt.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from incsvr.learning.iteration import Settings
from incsvr.learning.model import Model
from incsvr.learning.noise import Noise
from incsvr.learning.vectors import Vectors
from incsvr.numerics import Array

GAIN_DEVIATION = 0.15
"""Standard deviation of a change's gain, as a part of the curve."""
SHAPE_NOISES = 0.4
"""Standard deviation of each polynomial, in noise levels σ."""
POLYNOMIAL_DEGREE = 4
"""Degree of the polynomials."""
WINDOW_BATCHES = (1, 2, 4)
"""Numbers of last batches that are weighed together."""
ALARM_LOG_ODDS = 5.0
"""Logarithm of the Bayes factor from which on the curve has moved."""
PROBATION_BATCHES = 4
"""Batches for which a correction is on probation."""
VECTORS_PER_FREEDOM = 10.0
"""Vectors that share one degree of freedom of a correction, about: 60 over six. Their doubts are the same doubt."""
YOUNG_CURVE_BATCHES = 3
"""Batches after which the curve is known well enough to be found changed."""


@dataclass(frozen=True, slots=True)
class Evidence:
    """The evidence of some samples about the correction."""

    information: Array  # A (p, p)
    score: Array  # v (p,)
    square: float  # eᵀΣ⁻¹e
    reach: float  # largest |r| among them [rad/s]


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
        index: (n,) their places in the stream, increasing.
    """
    probation, sentence = watch.probation, None
    # Both curves are judged by the same samples: those at rates that both knew.
    known = vectors.yaw_rate if probation is None else probation.vectors.yaw_rate
    inside = (rate >= known[0]) & (rate <= known[-1])
    rate, damping, predicted, index = rate[inside], damping[inside], predicted[inside], index[inside]
    fresh = _evidence(settings, noise, rate, damping, predicted, index)
    if probation is not None:
        before = _evidence(settings, noise, rate, damping, probation.model.evaluate(rate), index)
        change = _surprise([fresh], probation.precision) - _surprise([before], probation.held)
        lead = probation.lead + float(change[0]) + 0.5 * (fresh.square - before.square)
        if lead > ALARM_LOG_ODDS:
            sentence = f"the damping is as it was before the last change (ln Bayes factor {lead:.1f})"
            vectors, model, fresh, probation = probation.vectors, probation.model, before, None
        else:
            probation = replace(probation, lead=lead)

    seen = min(watch.seen + 1, YOUNG_CURVE_BATCHES)
    recent = (*watch.recent, fresh)[-WINDOW_BATCHES[-1] :]
    free = _prior(noise.sigma)
    at_vectors = _features(settings, vectors.yaw_rate, model.evaluate(vectors.yaw_rate))
    held = (at_vectors.T * (vectors.information * noise.worth)) @ at_vectors + free
    windows = [_together(recent[-count:]) for count in WINDOW_BATCHES if count <= len(recent)]
    log_factors = (_surprise(windows, held) - _surprise(windows, free)).tolist()
    log_factor = max(log_factors)
    evidence = windows[log_factors.index(log_factor)]
    changed = log_factor > ALARM_LOG_ODDS and seen >= YOUNG_CURVE_BATCHES
    if changed:
        precision = free + evidence.information
    elif probation is not None:
        evidence, precision = fresh, probation.precision + fresh.information
    else:
        return vectors, Watch(seen, recent), sentence

    if not changed:
        assert probation is not None
        probation = replace(probation, precision=precision, batches=probation.batches - 1)
        moved = _moved(settings, vectors, model, evidence, precision)[0]
        return moved, Watch(seen, (), probation if probation.batches else None), None
    moved, phi, correction = _moved(settings, vectors, model, evidence, precision)
    variance = (phi * np.linalg.solve(precision, phi.T).T).sum(axis=1)
    doubt = VECTORS_PER_FREEDOM * noise.worth * variance
    moved = replace(moved, information=1.0 / (1.0 / vectors.information + doubt))
    gain = 100.0 * float(correction @ phi[:, 0]) / max(float(phi[:, 0] @ phi[:, 0]), 1e-300)
    sentence = f"the damping has changed by about {gain:+.0f} % (ln Bayes factor {log_factor:.1f})"
    return moved, Watch(seen, (), Probation(precision, PROBATION_BATCHES, vectors, model, held)), sentence


def _moved(
    settings: Settings, vectors: Vectors, model: Model, evidence: Evidence, precision: Array
) -> tuple[Vectors, Array, Array]:
    """The vectors (n,) moved by the correction, its features (n, p), and itself [N m].

    It is not trusted beyond the largest rate that showed it: from there on it stays as it is.
    """
    reached = np.clip(vectors.yaw_rate, -evidence.reach, evidence.reach)
    phi = _features(settings, reached, model.evaluate(reached))
    correction = phi @ np.linalg.solve(precision, evidence.score)
    return replace(vectors, damping=vectors.damping + correction), phi, correction


def _features(settings: Settings, rate: Array, curve: Array) -> Array:
    """φ (n, p) at (n,) rates: the curve f [N m] there, and polynomials of the scaled rate, which stays in [−1, 1]."""
    low, high = settings.rate_range
    u = np.minimum(np.maximum((2.0 * rate - low - high) / (high - low), -1.0), 1.0)
    phi = np.empty((POLYNOMIAL_DEGREE + 2, u.size))
    phi[0], phi[1], phi[2] = curve, 1.0, u
    for row in range(3, POLYNOMIAL_DEGREE + 2):
        phi[row] = 2.0 * u * phi[row - 1] - phi[row - 2]
    return phi.T


def _prior(sigma: float) -> Array:
    """D (p, p), the precision of w, at a noise level of sigma [N m]."""
    size = POLYNOMIAL_DEGREE + 2
    found = np.zeros((size, size))
    found.reshape(-1)[:: size + 1] = (SHAPE_NOISES * sigma) ** -2
    found[0, 0] = GAIN_DEVIATION**-2
    return found


def _evidence(
    settings: Settings, noise: Noise, rate: Array, damping: Array, curve: Array, index: NDArray[np.intp]
) -> Evidence:
    """The evidence of (n,) samples against a curve: where some are missing in the stream the correlation of the noise
    is ρ to the power of the distance."""
    p = POLYNOMIAL_DEGREE + 2
    if rate.size == 0:
        return Evidence(np.zeros((p, p)), np.zeros(p), 0.0, 0.0)
    decay = noise.correlation ** (index[1:] - index[:-1])
    white = np.concatenate((_features(settings, rate, curve), (damping - curve)[:, None]), axis=1)
    white[1:] = (white[1:] - decay[:, None] * white[:-1]) / np.sqrt(1.0 - decay * decay)[:, None]
    gram = white.T @ white / noise.variance
    return Evidence(gram[:p, :p], gram[:p, p], float(gram[p, p]), float(np.abs(rate).max()))


def _together(parts: Sequence[Evidence]) -> Evidence:
    """The evidence of several batches, at least one."""
    return Evidence(
        sum((part.information for part in parts[1:]), parts[0].information),
        sum((part.score for part in parts[1:]), parts[0].score),
        sum(part.square for part in parts),
        max(part.reach for part in parts),
    )


def _surprise(windows: Sequence[Evidence], precision: Array) -> Array:
    """(windows,) −ln p(e) without ½ eᵀΣ⁻¹e, up to a constant, for a correction of precision P (p, p) about zero."""
    informed = np.array([window.information for window in windows]) + precision
    score = np.array([window.score for window in windows])
    pull = np.vecdot(score, np.linalg.solve(informed, score[..., None])[..., 0])
    sizes = np.linalg.slogdet(np.concatenate((informed, precision[None])))[1]
    return np.asarray(0.5 * (sizes[:-1] - sizes[-1] - pull))
