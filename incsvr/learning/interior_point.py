"""Mehrotra's predictor–corrector interior point for Eq. 7, and the step from near its solution to the solution itself.

The kernel matrix is K = L Lᵀ with few columns, so that an iteration costs n·rank². Here the number of calls is what
costs, not that of operations: what is alike lies side by side in one array, whose parts have names of their own.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array, lapack

MAX_ITERATIONS = 60
"""Iterations at most; 8 to 13 are usual, whatever the data."""
NEAR_END_SHARE = 1e-4
"""Part of the first complementarity that is left when an iterate is worth looking at."""


class Iterate(NamedTuple):
    """A point near the end of the central path."""

    number: int  # of the iteration, from 1
    theta: Array  # (n,) θ = α − β, inside its bounds
    between: NDArray[np.bool_]  # (n,) True where α or β seems to end between its bounds rather than on one


def path(LT: Array, y: Array, bound: Array, tube: Array) -> Iterator[Iterate]:
    """Follows the central path of min ½ θᵀKθ + Σ εᵢ|θᵢ| − yᵀθ over |θᵢ| ≤ Cᵢ until rounding ends it.

    θ = α − β with 0 ≤ α, β ≤ C. The multipliers of α ≥ 0 and α ≤ C are s, ξ ≥ 0 with s − ξ = ε − y + f; those of β
    have s − ξ = ε + y − f; f = Kθ. All but w = Lᵀθ is eliminated: (I + Lᵀ D L) dw = …, of the size of the rank.

    Args:
        LT: (rank, n) Lᵀ.
        y, bound, tube: (n,) damping, Cᵢ and εᵢ [N m].
    """
    point, w = _start(LT, y, bound, tube)
    x, s = point[:2], point[2:]  # (α, β), (C − α, C − β) and s, ξ of both
    (alpha, beta), s_lower, s_upper = point[0], point[2], point[3]
    flat_x, flat_s, pairs = x.reshape(-1), s.reshape(-1), x.size
    normal, step = _Normal(LT), np.empty_like(point)
    dx, ds, dx_lower, dx_upper = step[:2], step[2:], step[0], step[1]
    off = LT.dot(alpha - beta) - w  # the error of the carried w
    mu = first = lowest = float(flat_x.dot(flat_s)) / pairs
    falling = True
    for number in range(1, MAX_ITERATIONS + 1):
        quotient = s / x
        freedom = 1.0 / (quotient[0] + quotient[1])
        if not normal.weigh(freedom):
            return
        # The predictor, straight at the solution: dx/x + ds/s = −1 there, so one quotient tells the length of both.
        g, dw = normal.solve(s_upper - s_lower, freedom, off)
        t = g / x
        np.negative(t[1], t[1])
        length = min(1.0, 1.0 / max(-float(t.min()), 1.0 + float(t.max())))
        affine = (1.0 - length) * mu + length * length * float((dw - off).dot(dw)) / pairs
        target, correction = mu * min(1.0, max(affine / mu, 0.0)) ** 3, 1.0
        # Mehrotra's method can go round in circles; nearer to the centre, with less correction, it ends.
        if not falling:
            target, correction = max(target, 0.2 * mu), length
        second = t * t
        second += t
        second *= correction
        second -= 1.0
        second *= s
        second += target / x
        g, dw = normal.solve(second[0] - second[1], freedom, off)
        np.copyto(dx_lower, g)
        np.negative(g, dx_upper)
        quotient *= dx
        np.subtract(second, quotient, ds)
        relative = step / point
        longest = -float(relative.min())
        length = 1.0 if longest <= 0.995 else 0.995 / longest
        step *= length
        point += step
        off *= 1.0 - length
        mu = float(flat_x.dot(flat_s)) / pairs
        if not 0.0 < mu < np.inf:
            return
        falling = mu < 0.5 * lowest
        lowest = mu if falling else lowest
        if mu <= NEAR_END_SHARE * first or number == MAX_ITERATIONS:
            theta = np.minimum(np.maximum(alpha - beta, -bound), bound)  # rounding may have gone past
            # Of two whose product goes to zero the one that shrinks less is the one that stays (Tapia's indicator).
            stays = relative[:2] > relative[2:]
            loose = stays[0] & stays[1]
            yield Iterate(number, theta, loose[0] | loose[1])
            if mu <= 1e-16 * first or length < 1e-6:
                return


class _Normal:
    """The equations (I + Lᵀ D L) dw = Lᵀ h + off of one iterate after the other."""

    def __init__(self, LT: Array) -> None:
        self._LT, rank = LT, LT.shape[0]
        self._scaled, self._whole = np.empty_like(LT), np.empty((rank, rank))
        self._diagonal = self._whole.reshape(-1)[:: rank + 1]

    def weigh(self, freedom: Array) -> bool:
        """Makes ready for D = diag of the sum of `freedom` (2, n); whether it could."""
        np.multiply(self._LT, np.sqrt(freedom[0] + freedom[1]), self._scaled)
        np.dot(self._scaled, self._scaled.T, self._whole)
        self._diagonal += 1.0
        # lower, its upper part left as it is, in place
        self._cholesky, failed = lapack.dpotrf(self._whole.T, 1, 0, 1)
        return not failed

    def solve(self, g: Array, freedom: Array, off: Array) -> tuple[Array, Array]:
        """The step of (α, β) for the right-hand side g, each (2, n), and dw."""
        h = g * freedom
        dw = lapack.dpotrs(self._cholesky, self._LT.dot(h[0] - h[1]) + off, 1)[0]
        df = dw.dot(self._LT)
        g[0] -= df
        g[1] += df
        g *= freedom
        return g, dw


def _start(LT: Array, y: Array, bound: Array, tube: Array) -> tuple[Array, Array]:
    """A point (4, 2, n) on the central path but for w, and w: (α, β), (C − α, C − β), then their s and ξ.

    Ridge least squares tell the residuals; then every complementarity product is made the same μ. Ridge and μ are a
    tenth of their scales: fewest iterations in a trial.
    """
    n = y.size
    size, limit = float(np.abs(y).sum()) / n, float(bound.sum()) / n
    normal = LT.dot(LT.T)
    normal.reshape(-1)[:: normal.shape[0] + 1] += 0.1 * size / limit
    w = lapack.dposv(normal, LT.dot(y), lower=1)[1]
    residual = y - w.dot(LT)
    mu = 0.1 * limit * (float(np.abs(residual).sum() + tube.sum()) / n + 1e-3 * size)
    # α s = (C − α) ξ = μ and s − ξ = t make a quadratic in s and one in ξ.
    t = np.array((tube - residual, tube + residual)) * bound
    root = np.sqrt(t * t + 4.0 * mu * mu) + 2.0 * mu
    point = np.empty((4, 2, n))
    point[2], point[3] = root + t, root - t
    point[2:] /= 2.0 * bound
    np.divide(mu, point[2:], point[:2])
    return point, w


def cross(LT: Array, y: Array, bound: Array, tube: Array, near: Iterate) -> Array:
    """θ whose weights on a bound are exactly there and whose others put their samples exactly on the tube's edge.

    The latter are one small linear system, K_FF δ = y − sε − f on the free samples F, with s the sign of the weight.
    Where ties leave more of them free than are independent (gridded data, duplicates) the rest keeps its weight.

    Args:
        LT, y, bound, tube: as for `path`.
        near: a point near the solution.
    """
    free = near.between.nonzero()[0]
    exact = np.rint(near.theta / bound) * bound
    if free.size:
        exact[free] = loose = near.theta[free]
        LF = LT.take(free, axis=1)
        missing = y[free] - np.copysign(tube[free], loose) - LT.dot(exact).dot(LF)
        cholesky, pivots, rank, _ = lapack.dpstrf(LF.T.dot(LF), tol=1e-14, lower=1)  # closer ones add nothing
        pivots = pivots[:rank] - 1
        exact[free[pivots]] += lapack.dpotrs(cholesky[:rank, :rank], missing[pivots], lower=1)[0]
        exact = np.maximum(np.minimum(exact, bound), -bound)
    return exact
