"""Has the vehicle changed? A Bayes factor between "what is learned holds" and "the curve has moved smoothly".

What the curve leaves over of a batch, e = y − f(x), may hold a smooth correction g(x) = φ(x)ᵀw: a gain on the curve,
since a new hull scales drag, and Chebyshev polynomials of the yaw rate for all other changes. Whitened for the lag-1
correlation of the noise, some batches say about w only A = Σ φφᵀ/σ² and v = Σ φe/σ². With D, the prior's precision,
and M, what the memory knows in the same form,

    H0, what is learned holds:  w ~ N(0, (M + D)⁻¹)        H1, the curve has moved:  w ~ N(0, D⁻¹)

    ln BF = ½ vᵀ[(A + D)⁻¹ − (A + M + D)⁻¹]v + ½ ln |A + M + D| |D| / (|A + D| |M + D|).

Where the memory knows nothing both say the same, so new territory is no change. Correlation takes evidence away, as it
must (the whitened share of a level shift is 1 − ρ); instead of asking each sample for the rest, as a CUSUM does, the
factor adds it up over the last one, two and four batches. Under H1 the correction is w = (A + D)⁻¹v with covariance
(A + D)⁻¹.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from incsvr.noise import Noise
from incsvr.samples import Array

GAIN = 0.15
"""Standard deviation of a change's gain, as a part of the curve."""
SHAPE = 0.4
"""Standard deviation of each polynomial, in noise levels σ."""
DEGREE = 4
"""Of the polynomials."""
WINDOWS = (1, 2, 4)
"""Last batches that are weighed together."""
ALARM = 3.5
"""ln of the Bayes factor from which on the curve has moved."""


@dataclass(frozen=True, slots=True)
class Evidence:
    """What some samples say about the correction.

    Attributes:
        information: A (p, p).
        score: v (p,).
        reach: largest |r| among them [rad/s].
    """

    information: Array
    score: Array
    reach: float

    def to_dict(self) -> dict[str, Any]:
        return {"information": self.information.tolist(), "score": self.score.tolist(), "reach": self.reach}

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> Evidence:
        return Evidence(np.array(data["information"]), np.array(data["score"]), data["reach"])


def features(u: Array, curve: Array) -> Array:
    """φ (n, p): the curve f [N m] and the polynomials, at rates scaled to u ∈ [−1, 1] (n,); beyond, they stay."""
    u = np.clip(u, -1.0, 1.0)
    columns = [curve, np.ones(u.size), u]
    for _ in range(DEGREE - 1):
        columns.append(2.0 * u * columns[-1] - columns[-2])
    return np.stack(columns, axis=1)


def prior(sigma: float) -> Array:
    """D (p, p), the precision of w, at a noise level of sigma [N m]."""
    return np.diag([GAIN**-2] + [(SHAPE * sigma) ** -2] * (DEGREE + 1))


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
        return Evidence(np.zeros((p, p)), np.zeros(p), 0.0)
    decay = noise.correlation ** (index[1:] - index[:-1])
    white = np.concatenate((phi, residual[:, None]), axis=1)
    white[1:] = (white[1:] - decay[:, None] * white[:-1]) / np.sqrt(1.0 - decay * decay)[:, None]
    gram = white.T @ white / noise.variance
    return Evidence(gram[:p, :p], gram[:p, p], float(np.abs(rate).max()))


def together(parts: Sequence[Evidence]) -> Evidence:
    """The evidence of several batches, at least one."""
    return Evidence(
        sum((part.information for part in parts[1:]), parts[0].information),
        sum((part.score for part in parts[1:]), parts[0].score),
        max(part.reach for part in parts),
    )


class Verdict(NamedTuple):
    """The strongest case for a change: ln BF and the evidence of that window."""

    log_factor: float
    evidence: Evidence


def weigh(recent: Sequence[Evidence], memory: Array, precision: Array) -> Verdict:
    """Weighs the last 1, 2, 4 batches of `recent` (oldest first, at least one).

    Args:
        recent: evidence of each batch against the curve of its time.
        memory: M (p, p).
        precision: D (p, p).
    """
    held = memory + precision
    windows = [together(recent[-count:]) for count in WINDOWS if count <= len(recent)]
    both = np.array([[window.information + precision, window.information + held] for window in windows])
    score = np.array([[window.score, window.score] for window in windows])
    pull = (score * np.linalg.solve(both, score[..., None])[..., 0]).sum(axis=-1)
    size = np.linalg.slogdet(both)[1]
    least = float(np.log(np.diag(precision)).sum()) - np.linalg.slogdet(held)[1]
    factors = 0.5 * (pull[:, 0] - pull[:, 1] + size[:, 1] - size[:, 0] + least)
    best = int(factors.argmax())
    return Verdict(float(factors[best]), windows[best])
