"""Mehrotra's predictor–corrector interior point for Eq. 7."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from incsvr.learning.solver.matrix import Matrix
from incsvr.numerics import Array

MAX_ITERATIONS = 60
"""Iterations at most; 8 to 13 are usual, whatever the data."""
NEAR_END_SHARE = 1e-4
"""Part of the first complementarity that is left when an iterate is worth looking at."""
START_RIDGE = 0.1
"""Ridge at the start, in mean|y| / mean(C), the scale between a residual and a weight; fewest iterations in a trial."""
START_COMPLEMENTARITY = 0.1
"""Complementarity at the start, in mean(C)·mean|residual|; fewest iterations in a trial."""


@dataclass(frozen=True, slots=True)
class Iterate:
    """A point near the end of the central path.

    Attributes:
        number: of the iteration, from 1.
        theta: (n,) θ = α − β, inside its bounds.
        between: (n,) True where α or β seems to end between its bounds rather than on one.
    """

    number: int
    theta: Array
    between: NDArray[np.bool_]


def path(matrix: Matrix, y: Array, bound: Array, tube: Array) -> Iterator[Iterate]:
    """Follows the central path of min ½ θᵀKθ + Σ εᵢ|θᵢ| − yᵀθ over |θᵢ| ≤ Cᵢ until rounding ends it.

    θ = α − β with 0 ≤ α, β ≤ C. The multipliers of α ≥ 0 and α ≤ C are s, ξ ≥ 0 with s − ξ = ε − y + f; those of β
    have s − ξ = ε + y − f; f = Kθ. All but w = Lᵀθ is eliminated, K = L Lᵀ: (I + Lᵀ D L) dw = …, of the size of the
    rank, or all but f where K is whole. What is alike lies side by side in one array: the cost here is the number of
    calls, not of operations.

    Args:
        matrix: K.
        y, bound, tube: (n,) damping, Cᵢ and εᵢ [N m].
    """
    n = y.size
    point, w = _start(matrix, y, bound, tube)
    x, s = point[:2], point[2:]  # (α, β) and (C − α, C − β); their s and ξ
    step, relative = np.empty_like(point), np.empty_like(point)
    dx, ds = step[:2], step[2:]
    quotient, u, t, v = (np.empty_like(x) for _ in range(4))
    freedom, g, h = np.empty((2, n)), np.empty((2, n)), np.empty((2, n))
    # Names for the parts, once: an index costs a fourth of an operation here.
    (alpha, beta), (s_lower, s_upper), (_, t_upper), (u_lower, u_upper) = x[0], s, t, u
    (quotient_lower, quotient_upper), (dx_lower, dx_upper) = quotient, dx
    (freedom_alpha, freedom_beta), (g_alpha, g_beta), (h_alpha, h_beta) = freedom, g, h
    flat_x, flat_s = x.reshape(-1), s.reshape(-1)
    off = matrix.apart(alpha - beta, w)
    mu = first = float(flat_x.dot(flat_s)) / (4 * n)
    lowest, falling = mu, True
    for number in range(1, MAX_ITERATIONS + 1):
        np.divide(s, x, quotient)
        np.add(quotient_lower, quotient_upper, freedom)
        np.reciprocal(freedom, freedom)
        if not matrix.weigh(freedom_alpha + freedom_beta):
            return
        # Predictor: straight at the solution. Here dx/x + ds/s = −1, so one quotient tells both step lengths.
        np.subtract(s_upper, s_lower, g)
        np.multiply(freedom, g, h)
        dw, q = matrix.step(h_alpha - h_beta, off)
        g_alpha -= q
        g_beta += q
        g *= freedom
        np.divide(g, x, t)
        np.negative(t_upper, t_upper)
        length = min(1.0, 1.0 / max(-float(t.min()), 1.0 + float(t.max())))
        affine = (1.0 - length) * mu + length * length * matrix.power(dw, off, g_alpha - g_beta) / (4 * n)
        target = mu * min(1.0, max(affine / mu, 0.0)) ** 3
        if (
            not falling
        ):  # Mehrotra's method can go round in circles; nearer to the centre, with less correction, it ends
            target = max(target, 0.2 * mu)
        # Corrector: towards the central path, with the second-order error of the predictor taken out.
        np.divide(target, x, u)
        np.multiply(t, t, v)
        v += t
        if not falling:
            v *= length
        v -= 1.0
        v *= s
        u += v
        np.subtract(u_lower, u_upper, g)
        np.multiply(freedom, g, h)
        q = matrix.step(h_alpha - h_beta, off)[1]
        g_alpha -= q
        g_beta += q
        np.multiply(g, freedom, dx_lower)
        np.negative(dx_lower, dx_upper)
        np.multiply(quotient, dx, t)
        np.subtract(u, t, ds)
        np.divide(step, point, relative)
        longest = -float(relative.min())
        length = 1.0 if longest <= 0.995 else 0.995 / longest
        step *= length
        point += step
        off *= 1.0 - length
        mu = float(flat_x.dot(flat_s)) / (4 * n)
        if not 0.0 < mu < np.inf:
            return
        falling = mu < 0.5 * lowest
        lowest = mu if falling else lowest
        if mu <= NEAR_END_SHARE * first or number == MAX_ITERATIONS:
            # Of two whose product goes to zero, the one that shrinks less is the one that stays (Tapia's indicator).
            stays = relative[:2] > relative[2:]
            loose = stays[0] & stays[1]
            theta = alpha - beta
            np.maximum(np.minimum(theta, bound, theta), -bound, theta)  # rounding may have gone past
            yield Iterate(number, theta, loose[0] | loose[1])
            if mu <= 1e-16 * first or length < 1e-6:
                return


def _start(matrix: Matrix, y: Array, bound: Array, tube: Array) -> tuple[Array, Array]:
    """A point on the central path but for what is carried, and that.

    Ridge least squares tell the residuals; then every complementarity product is made the same μ.
    """
    n = y.size
    size, limit = float(np.abs(y).sum()) / n, float(bound.sum()) / n
    w, f = matrix.ridge(y, START_RIDGE * size / limit)
    residual = y - f
    mu = START_COMPLEMENTARITY * limit * (float(np.abs(residual).sum() + tube.sum()) / n + 1e-3 * size)
    # α s = (C − α) ξ = μ and s − ξ = t make a quadratic in s and one in ξ.
    t = np.empty((2, n))
    np.subtract(tube, residual, t[0])
    np.add(tube, residual, t[1])
    t *= bound
    root = np.sqrt(t * t + 4.0 * mu * mu)
    root += 2.0 * mu
    point = np.empty((4, 2, n))
    np.add(root, t, point[2])
    np.subtract(root, t, point[3])
    point[2:] /= 2.0 * bound
    np.divide(mu, point[2:], point[:2])
    return point, w
