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
    """A point near the end of the central path."""

    number: int  # of the iteration, from 1
    theta: Array  # (n,) θ = α − β, inside its bounds
    between: NDArray[np.bool_]  # (n,) True where α or β seems to end between its bounds rather than on one


def path(matrix: Matrix, y: Array, bound: Array, tube: Array) -> Iterator[Iterate]:
    """Follows the central path of min ½ θᵀKθ + Σ εᵢ|θᵢ| − yᵀθ over |θᵢ| ≤ Cᵢ until rounding ends it.

    θ = α − β with 0 ≤ α, β ≤ C. The multipliers of α ≥ 0 and α ≤ C are s, ξ ≥ 0 with s − ξ = ε − y + f; those of β
    have s − ξ = ε + y − f; f = Kθ. All but w = Lᵀθ is eliminated, K = L Lᵀ: (I + Lᵀ D L) dw = …, of the size of the
    rank, or all but f where K is whole.

    Args:
        matrix: K.
        y, bound, tube: (n,) damping, Cᵢ and εᵢ [N m].
    """
    point, w = _start(matrix, y, bound, tube)
    newton = _Newton(matrix, point, w)
    mu = first = lowest = newton.complementarity()
    falling = True
    for number in range(1, MAX_ITERATIONS + 1):
        if not newton.weigh():
            return
        length, affine = newton.predict(mu)
        target = mu * min(1.0, max(affine / mu, 0.0)) ** 3
        # Mehrotra's method can go round in circles; nearer to the centre, with less correction, it ends.
        if falling:
            newton.correct(target, 1.0)
        else:
            newton.correct(max(target, 0.2 * mu), length)
        length = newton.advance()
        mu = newton.complementarity()
        if not 0.0 < mu < np.inf:
            return
        falling = mu < 0.5 * lowest
        lowest = mu if falling else lowest
        if mu <= NEAR_END_SHARE * first or number == MAX_ITERATIONS:
            theta = newton.theta()
            np.maximum(np.minimum(theta, bound, theta), -bound, theta)  # rounding may have gone past
            yield Iterate(number, theta, newton.between())
            if mu <= 1e-16 * first or length < 1e-6:
                return


class _Newton:
    """A point of the path, and Newton's steps from it.

    What is alike lies side by side in one array: the cost here is the number of calls, not of operations. Its parts
    have names of their own, because an index costs a fourth of an operation.
    """

    __slots__ = (  # a table of its own would make an object with so many names slower
        *("_matrix", "_off", "_point", "_pairs", "_step", "_relative", "_flat_relative", "_x", "_s", "_flat_x"),
        *("_flat_s", "_alpha", "_beta", "_s_lower", "_s_upper", "_dx", "_ds", "_dx_lower", "_dx_upper", "_t"),
        *("_t_upper", "_flat_t", "_u", "_u_lower", "_u_upper", "_v", "_quotient", "_quotient_lower", "_quotient_upper"),
        *("_freedom", "_freedom_alpha", "_freedom_beta", "_g", "_g_alpha", "_g_beta", "_h", "_h_alpha", "_h_beta"),
    )

    def __init__(self, matrix: Matrix, point: Array, carried: Array) -> None:
        """Begins at a point (4, 2, n): (α, β), (C − α, C − β), then their s and ξ.

        Args:
            carried: what the matrix carries for it.
        """
        n: int = point.shape[2]
        self._matrix, self._point, self._pairs = matrix, point, 4 * n
        self._step, self._relative = np.empty_like(point), np.empty_like(point)
        self._x, self._s = point[:2], point[2:]
        self._quotient, self._t, self._u, self._v = (np.empty_like(self._x) for _ in range(4))
        self._freedom, self._g, self._h = np.empty((2, n)), np.empty((2, n)), np.empty((2, n))
        (self._alpha, self._beta), (self._s_lower, self._s_upper) = self._x[0], self._s
        self._flat_x, self._flat_s = self._x.reshape(-1), self._s.reshape(-1)
        self._flat_t, self._flat_relative = self._t.reshape(-1), self._relative.reshape(-1)
        self._dx, self._ds = self._step[:2], self._step[2:]
        (self._dx_lower, self._dx_upper), (self._u_lower, self._u_upper) = self._dx, self._u
        self._t_upper = self._t[1]
        self._quotient_lower, self._quotient_upper = self._quotient
        self._freedom_alpha, self._freedom_beta = self._freedom
        (self._g_alpha, self._g_beta), (self._h_alpha, self._h_beta) = self._g, self._h
        self._off = matrix.apart(self._alpha - self._beta, carried)

    def theta(self) -> Array:
        """θ = α − β (n,)."""
        return np.asarray(self._alpha - self._beta)

    def complementarity(self) -> float:
        """The mean product of a distance from a bound and its multiplier."""
        return float(self._flat_x.dot(self._flat_s)) / self._pairs

    def weigh(self) -> bool:
        """Makes the equations of this point ready; whether it could."""
        freedom = self._freedom
        np.divide(self._s, self._x, self._quotient)
        np.add(self._quotient_lower, self._quotient_upper, freedom)
        np.reciprocal(freedom, freedom)
        return self._matrix.weigh(self._freedom_alpha + self._freedom_beta)

    def predict(self, mu: float) -> tuple[float, float]:
        """Mehrotra's predictor, straight at the solution: its length, and the complementarity there.

        Here dx/x + ds/s = −1, so one quotient tells the length of both.

        Args:
            mu: complementarity of the point.
        """
        g, t, flat_t = self._g, self._t, self._flat_t
        np.subtract(self._s_upper, self._s_lower, g)
        dw = self._solve()
        g *= self._freedom
        np.divide(g, self._x, t)
        np.negative(self._t_upper, self._t_upper)
        length = min(1.0, 1.0 / max(-float(np.minimum.reduce(flat_t)), 1.0 + float(np.maximum.reduce(flat_t))))
        power = self._matrix.power(dw, self._off, self._g_alpha - self._g_beta)
        return length, (1.0 - length) * mu + length * length * power / self._pairs

    def correct(self, target: float, correction: float) -> None:
        """The step to the complementarity `target` on the path, after `predict`.

        Args:
            correction: part of the predictor's second-order error that is taken out.
        """
        t, u, v = self._t, self._u, self._v
        np.divide(target, self._x, u)
        np.multiply(t, t, v)
        v += t
        if correction < 1.0:
            v *= correction
        v -= 1.0
        v *= self._s
        u += v
        np.subtract(self._u_lower, self._u_upper, self._g)
        self._solve()
        np.multiply(self._g, self._freedom, self._dx_lower)
        np.negative(self._dx_lower, self._dx_upper)
        np.multiply(self._quotient, self._dx, t)
        np.subtract(u, t, self._ds)

    def advance(self) -> float:
        """Takes the step as far as the bounds allow; its length."""
        step = self._step
        np.divide(step, self._point, self._relative)
        longest = -float(np.minimum.reduce(self._flat_relative))
        length = 1.0 if longest <= 0.995 else 0.995 / longest
        step *= length
        self._point += step
        self._off *= 1.0 - length
        return length

    def between(self) -> NDArray[np.bool_]:
        """Where α or β stays between its bounds (n,): of two whose product goes to zero, the one that shrinks less is
        the one that stays (Tapia's indicator)."""
        stays = self._relative[:2] > self._relative[2:]
        loose = stays[0] & stays[1]
        return np.asarray(loose[0] | loose[1])

    def _solve(self) -> Array:
        """Solves for the right-hand side g, from which the step of f is taken; the step of what the matrix carries."""
        np.multiply(self._freedom, self._g, self._h)
        dw, df = self._matrix.step(self._h_alpha - self._h_beta, self._off)
        self._g_alpha -= df
        self._g_beta += df
        return dw


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
