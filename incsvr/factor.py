"""The kernel matrix as a product L Lᵀ of few columns: its rank on one vehicle's yaw rates is about ten."""

from __future__ import annotations

import numpy as np
from scipy.linalg import lapack

from incsvr.kernel import rbf
from incsvr.samples import Array

SMALL = 256  # samples up to which the kernel matrix itself is formed: at most half a megabyte
TOLERANCE = 1e-15  # of the diagonal that is left; κ(x, x) = 1


def factor(x: Array, gamma: float) -> Array:
    """L of shape (n, rank) with L Lᵀ = K, by Cholesky with diagonal pivots.

    Beyond `SMALL` samples the columns of K are computed one by one as the pivots need them: memory is n·rank.
    """
    if x.shape[0] <= SMALL:
        lower, pivots, rank, _ = lapack.dpstrf(rbf(x, x, gamma), tol=TOLERANCE, lower=1)
        L = np.empty((x.shape[0], rank))
        L[pivots - 1] = np.tril(lower[:, :rank])
        return L
    left = np.ones(x.shape[0])
    rows: list[Array] = []
    while len(rows) < x.shape[0]:
        pivot = int(left.argmax())
        if left[pivot] <= TOLERANCE:
            break
        row = rbf(x[pivot : pivot + 1], x, gamma)[0]
        if rows:
            known = np.array(rows)
            row -= known[:, pivot] @ known
        row /= np.sqrt(left[pivot])
        rows.append(row)
        left -= row * row
        left[pivot] = 0.0
    return np.array(rows).T
