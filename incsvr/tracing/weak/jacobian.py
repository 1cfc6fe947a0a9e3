"""How the columns of a regression answer the noise: the Jacobian of its likelihood.

Where the noise u turned the vehicle, and with it the columns X, the density of y holds Σ ln((1 + jacobian₀ θ)/(1 +
jacobian₁ θ)), without which drag and inertia would be underestimated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from incsvr.tracing.run import Array
from incsvr.tracing.weak.noise_autocorrelation import with_history
from incsvr.tracing.weak.weak_form import Blocks

LEAST = 0.1
"""By which a block's noise may be stretched: a fit so far off the mark would have no density, and none pulls there."""

MOVED = 0.1
"""Part of a stretch: with less its curvature, half of a step's cost, may stay what it was."""


@dataclass(frozen=True, slots=True)
class Answer:
    """How columns stretch the noise of their own block, by 1 + part θ.

    Attributes:
        sign: 1 where the residual grows with the noise, −1 where it is held back.
        columns: (p',) which of the regression's columns answer at all.
        part: (m, p') by how much.
    """

    sign: float
    columns: NDArray[np.intp]
    part: Array

    def stretch(self, theta: Array) -> Array:
        """(m,) the factor, held above the least."""
        stretch: Array = np.maximum(1.0 + self.part @ theta[self.columns], LEAST)
        return stretch

    def shrink(self, theta: Array) -> Array:
        """(m,) one over the factor; zero where that is held, for there nothing pulls."""
        stretch = self.stretch(theta)
        return np.where(stretch > LEAST, 1.0 / stretch, 0.0)


def answering(jacobian: Array | None, blocks: Blocks) -> list[Answer]:
    """Of `jacobian` (2, n_b, p) what is not zero, in the blocks that count."""
    found = []
    for sign, part in () if jacobian is None else zip((1.0, -1.0), jacobian, strict=True):
        columns = np.flatnonzero(part.any(axis=0))
        if columns.size:
            kept = part if columns.size == part.shape[1] else part.T[columns].T
            found.append(Answer(sign, columns, with_history(kept, blocks)))
    return found


def log_determinant(own: Sequence[Answer], theta: Array) -> float:
    """Σ ln of the factors."""
    return sum(answer.sign * float(np.sum(np.log(answer.stretch(theta)))) for answer in own)


def moved(shrunk: Sequence[Array], before: Sequence[Array]) -> bool:
    """Whether a factor is another than it was."""
    pairs = zip(shrunk, before, strict=True)
    return any(bool(np.any(np.abs(now - old) > MOVED * old)) for now, old in pairs)


def pull(own: Sequence[Answer], shrunk: Sequence[Array], p: int) -> Array:
    """(p,) derivative of the logarithm by θ."""
    pull = np.zeros(p)
    for answer, each in zip(own, shrunk, strict=True):
        pull[answer.columns] += answer.sign * (each @ answer.part)
    return pull


def curvature(own: Sequence[Answer], shrunk: Sequence[Array], p: int) -> Array:
    """(p, p) less the second derivative, of the part that grows.

    With that of the other part the curvature might have any sign, and Newton's steps go anywhere; without it they are
    but shorter.
    """
    curved = np.zeros((p, p))
    for answer, each in zip(own, shrunk, strict=True):
        if answer.sign > 0.0:
            scaled = answer.part * each[:, None]
            curved[np.ix_(answer.columns, answer.columns)] += scaled.T @ scaled
    return curved
