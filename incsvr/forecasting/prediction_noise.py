"""The noise of errors of prediction from one command to the next: (1 − φB) e = (1 + c₁B + c₂B²) innovation.

The water lasts, and the gyro's noise comes with both its signs. LAPACK's banded solver filters it: a learner does
without SciPy's filters, which take 60 MB.
"""

from __future__ import annotations

from math import exp, tanh

import numpy as np

from incsvr.numerics import Array, lapack, robust_deviation

START = (2.0, -1.0, 0.0)
"""The noise from which a fit begins: logit of φ, and twice the inverse hyperbolic tangents of two reflections k, of
which c₂ = k₂ and c₁ = k₁ (1 + k₂) are invertible for every pair."""
MAX_SIZE = 8.0
"""Size of each of these numbers at most."""
NUDGE = 0.02
"""By how much each is moved for a slope."""
ROUNDS, TRIALS = 10, 6
"""Steps of a fit, and shorter ones that are tried for each."""
MIN_GAIN_SHARE = 1e-4
"""Part of the cost by which a step must lower it for another to follow."""
CLIPPED_DEVIATIONS = 4.0
"""Deviations beyond which an innovation counts as one at that distance."""


def whiten(noise: Array, values: Array) -> Array:
    """(n, k) columns as their innovations, where they have this noise (3,); zero before the first."""
    pole = 1.0 / (1.0 + exp(-float(noise[0])))
    first, second = tanh(0.5 * float(noise[1])), tanh(0.5 * float(noise[2]))
    moved = values.copy(order="F")
    moved[1:] -= pole * values[:-1]
    band = np.ones((3, values.shape[0]), order="F")
    band[1], band[2] = first * (1.0 + second), second
    white, failed = lapack.dtbtrs(band, moved, uplo="L", diag="U", overwrite_b=1)
    if failed:
        raise np.linalg.LinAlgError("a triangular system with a unit diagonal has no solution")
    return np.asarray(white)


def fitted_noise(error: Array, causes: Array, noise: Array) -> Array:
    """(3,) the noise of what causes (n, p) leave of (n,) errors, fitted together with them (Levenberg–Marquardt).

    Args:
        error: (n,).
        causes: (n, p).
        noise: (3,) from which to begin.
    """
    white = whiten(noise, np.column_stack((error, causes)))
    size: Array = np.asarray(np.linalg.lstsq(white[:, 1:], white[:, 0], rcond=None)[0], dtype=np.float64)
    rest = _Rest(error, causes, CLIPPED_DEVIATIONS * max(robust_deviation(white[:, 0] - white[:, 1:] @ size), 1e-12))
    left, damped = rest.of(size, noise), 1e-3
    cost = rest.cost(left)
    for _ in range(ROUNDS):
        jacobian = rest.jacobian(size, noise)
        square = jacobian.T @ jacobian
        pull = jacobian.T @ np.clip(left, -rest.limit, rest.limit)
        ridge, before = 1e-12 * np.trace(square) * np.eye(pull.size), cost
        for _ in range(TRIALS):
            step = np.linalg.solve(square + damped * np.diag(np.diag(square)) + ridge, -pull)
            tried = size + step[: size.size], np.clip(noise + step[size.size :], -MAX_SIZE, MAX_SIZE)
            there = rest.of(*tried)
            if rest.cost(there) < cost:
                (size, noise), left, cost, damped = tried, there, rest.cost(there), max(0.2 * damped, 1e-6)
                break
            damped *= 6.0
        if before - cost < MIN_GAIN_SHARE * cost:
            break
    return noise


class _Rest:
    """What is left of errors (n,) beside causes (n, p); beyond `limit` it counts as the limit."""

    def __init__(self, error: Array, causes: Array, limit: float) -> None:
        self._error, self._causes, self.limit = error, causes, limit

    def of(self, size: Array, noise: Array) -> Array:
        """(n,) the innovations of what is left."""
        return whiten(noise, (self._error - self._causes @ size)[:, None])[:, 0]

    def cost(self, left: Array) -> float:
        """Huber's sum of squares."""
        near = np.minimum(np.abs(left), self.limit)
        return float(np.sum(near * (2.0 * np.abs(left) - near)))

    def jacobian(self, size: Array, noise: Array) -> Array:
        """(n, p + 3) slopes of the innovations by the sizes of the causes and by the noise."""
        slopes = [
            (self.of(size, noise + nudge) - self.of(size, noise - nudge)) / (2.0 * NUDGE) for nudge in NUDGE * np.eye(3)
        ]
        return np.column_stack((-whiten(noise, self._causes), *slopes))
