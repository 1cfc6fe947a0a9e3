"""From a point near the solution to the solution itself, once it is known which weights lie between their bounds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from incsvr.samples import Array

INDEPENDENT = 1e-14  # of κ(x, x) = 1: samples closer to the others' span than this add nothing to it


def cross(LT: Array, y: Array, bound: Array, tube: Array, theta: Array, between: NDArray[np.bool_]) -> Array:
    """θ whose weights on a bound are exactly there and whose others put their samples exactly on the tube's edge.

    The latter are one small linear system, K_FF δ = y − sε − f on the free samples F, with s the sign of the weight.
    Where ties leave more of them free than are independent (gridded data, duplicates) the rest keeps its weight.

    Args:
        LT: (rank, n) Lᵀ, with K = L Lᵀ.
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
        LF = LT.take(free, axis=1)
        missing = y[free] - np.copysign(tube[free], near) - LT.dot(exact).dot(LF)
        cholesky, pivots, rank, _ = lapack.dpstrf(LF.T.dot(LF), tol=INDEPENDENT, lower=1)
        pivots = pivots[:rank] - 1
        exact[free[pivots]] += lapack.dpotrs(cholesky[:rank, :rank], missing[pivots], lower=1)[0]
        np.maximum(np.minimum(exact, bound, out=exact), -bound, out=exact)
    return exact
