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
from typing import NamedTuple

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


def features(u: Array, curve: Array) -> Array:
    """φ (n, p): the curve f [N m] and the polynomials, at rates scaled to u ∈ [−1, 1] (n,); beyond, they stay."""
    u = np.minimum(np.maximum(u, -1.0), 1.0)
    phi = np.empty((POLYNOMIAL_DEGREE + 2, u.size))
    phi[0], phi[1], phi[2] = curve, 1.0, u
    for row in range(3, POLYNOMIAL_DEGREE + 2):
        phi[row] = 2.0 * u * phi[row - 1] - phi[row - 2]
    return phi.T


def prior(sigma: float) -> Array:
    """D (p, p), the precision of w, at a noise level of sigma [N m]."""
    return np.diag([GAIN_DEVIATION**-2] + [(SHAPE_NOISES * sigma) ** -2] * (POLYNOMIAL_DEGREE + 1))


def gather(rate: Array, phi: Array, residual: Array, index: NDArray[np.intp], noise: Noise) -> Evidence:
    """The evidence of one batch.

    Args:
        rate: (n,) yaw rates [rad/s].
        phi: (n, p) their features.
        residual: (n,) y − f(x) [N m].
        index: (n,) place of each in the stream, increasing: where some are missing the correlation is ρ to the power of
            the distance.
        noise: of the samples.
    """
    p = phi.shape[1]
    if residual.size == 0:
        return Evidence(np.zeros((p, p)), np.zeros(p), 0.0, 0.0)
    decay = noise.correlation ** (index[1:] - index[:-1])
    white = np.concatenate((phi, residual[:, None]), axis=1)
    white[1:] = (white[1:] - decay[:, None] * white[:-1]) / np.sqrt(1.0 - decay * decay)[:, None]
    gram = white.T @ white / noise.variance
    return Evidence(gram[:p, :p], gram[:p, p], float(gram[p, p]), float(np.abs(rate).max()))


def together(parts: Sequence[Evidence]) -> Evidence:
    """The evidence of several batches, at least one."""
    return Evidence(
        sum((part.information for part in parts[1:]), parts[0].information),
        sum((part.score for part in parts[1:]), parts[0].score),
        sum(part.square for part in parts),
        max(part.reach for part in parts),
    )


def surprise(evidence: Evidence, precision: Array) -> float:
    """−ln p(e) up to a constant, for a correction of precision P (p, p) about zero."""
    informed = evidence.information + precision
    pull = float(evidence.score @ np.linalg.solve(informed, evidence.score))
    sizes = np.linalg.slogdet(np.stack((informed, precision)))[1]
    return 0.5 * (evidence.square - pull + float(sizes[0] - sizes[1]))


class Verdict(NamedTuple):
    """The strongest case for a change: ln BF and the evidence of that window."""

    log_factor: float
    evidence: Evidence


def weigh(recent: Sequence[Evidence], held: Array, free: Array) -> Verdict:
    """Weighs the last 1, 2, 4 batches of `recent` (oldest first, at least one).

    Args:
        recent: evidence of each batch against the curve of its time.
        held, free: M + D and D, (p, p).
    """
    windows = [together(recent[-count:]) for count in WINDOW_BATCHES if count <= len(recent)]
    # All windows, and none, under both hypotheses at once: for matrices this small the calls are what costs.
    precision = np.array((held, free))
    informed = np.array([window.information for window in windows])[:, None] + precision
    score = np.array([window.score for window in windows])[:, None, :, None]
    pull = (score * np.linalg.solve(informed, score)).sum(axis=(2, 3))
    size = np.linalg.slogdet(np.concatenate((precision, informed.reshape(-1, *free.shape))))[1].reshape(-1, 2)
    surprises = 0.5 * (size[1:] - size[0] - pull)  # without the square, which is the same for both
    factors = (surprises[:, 0] - surprises[:, 1]).tolist()
    best = factors.index(max(factors))
    return Verdict(factors[best], windows[best])


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
    probation, sentence = watch.probation, None
    # Both curves are judged by the same samples: those at rates that both knew.
    known = vectors.yaw_rate if probation is None else probation.vectors.yaw_rate
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
        else:
            probation = replace(probation, lead=lead)

    seen = min(watch.seen + 1, YOUNG_CURVE_BATCHES)
    recent = (*watch.recent, fresh)[-WINDOW_BATCHES[-1] :]
    free = prior(noise.sigma)
    at_vectors = _features(settings, vectors.yaw_rate, model.at_support)
    held = (at_vectors.T * (vectors.information * noise.worth)) @ at_vectors + free
    log_factor, evidence = weigh(recent, held, free)
    changed = log_factor > ALARM_LOG_ODDS and seen >= YOUNG_CURVE_BATCHES
    if changed:
        precision = free + evidence.information
    elif probation is not None:
        evidence, precision = fresh, probation.precision + fresh.information
    else:
        return vectors, Watch(seen, recent), sentence

    at_vectors, correction = _correction(settings, vectors.yaw_rate, model, evidence, precision)
    moved = replace(vectors, damping=vectors.damping + correction)
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
