"""The step from a point near the solution to the solution itself, once the weights between bounds are known."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from incsvr.learning.solver.matrix import Matrix
from incsvr.numerics import Array, lapack

MIN_INDEPENDENCE = 1e-14
"""Part of κ(x, x) = 1 that a sample adds to the others' span, at least: those closer to it add nothing."""


def cross(matrix: Matrix, y: Array, bound: Array, tube: Array, theta: Array, between: NDArray[np.bool_]) -> Array:
    """θ whose weights on a bound are exactly there and whose others put their samples exactly on the tube's edge.

    The latter are one small linear system, K_FF δ = y − sε − f on the free samples F, with s the sign of the weight.
    Where ties leave more of them free than are independent (gridded data, duplicates) the rest keeps its weight.

    Args:
        matrix: K.
        y, bound, tube: (n,) damping, Cᵢ and εᵢ [N m].
        theta: (n,) θ near the solution [N m].
        between: (n,) where |θᵢ| is neither 0 nor Cᵢ at the solution.
    """
    free = between.nonzero()[0]
    exact = theta / bound
    np.rint(exact, out=exact)
    exact *= bound
    if free.size:
        near = theta[free]
        exact[free] = near
        block, fitted = matrix.between(free, exact)
        missing = y[free] - np.copysign(tube[free], near) - fitted
        cholesky, pivots, rank, _ = lapack.dpstrf(block, tol=MIN_INDEPENDENCE, lower=1)
        pivots = pivots[:rank] - 1
        exact[free[pivots]] += lapack.dpotrs(cholesky[:rank, :rank], missing[pivots], lower=1)[0]
        np.maximum(np.minimum(exact, bound, out=exact), -bound, out=exact)
    return exact
