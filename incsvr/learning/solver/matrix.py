"""The kernel matrix in few columns, as the solver needs it: an iteration costs n·rank².

With D diagonal, w = Lᵀθ is what the interior point carries; its step solves (I + Lᵀ D L) dw = Lᵀ h + off.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array, lapack


class Matrix:
    """K = L Lᵀ, given as Lᵀ (rank, n)."""

    def __init__(self, LT: Array) -> None:
        self._LT = LT
        self.size = LT.shape[1]
        rank = LT.shape[0]
        self._scaled, self._normal = np.empty_like(LT), np.empty((rank, rank))
        self._diagonal = self._normal.reshape(-1)[:: rank + 1]
        self._cholesky = self._normal

    def product(self, theta: Array) -> Array:
        """Kθ (n,)."""
        return np.asarray(self._LT.dot(theta).dot(self._LT))

    def apart(self, theta: Array, carried: Array) -> Array:
        """The error of the carried vector against Lᵀθ."""
        return np.asarray(self._LT.dot(theta) - carried)

    def between(self, free: NDArray[np.intp], theta: Array) -> tuple[Array, Array]:
        """K on the free samples (m, m), and Kθ there (m,)."""
        LF = self._LT.take(free, axis=1)
        return LF.T.dot(LF), self._LT.dot(theta).dot(LF)

    def ridge(self, y: Array, ridge: float) -> tuple[Array, Array]:
        """The carried vector at the ridge regression of y, and f there (n,)."""
        normal = self._LT.dot(self._LT.T)
        normal.reshape(-1)[:: normal.shape[0] + 1] += ridge
        w = lapack.dposv(normal, self._LT.dot(y), lower=1)[1]
        return w, w.dot(self._LT)

    def weigh(self, weight: Array) -> bool:
        """Makes ready for steps with D = diag(weight); whether it could."""
        np.multiply(self._LT, np.sqrt(weight), self._scaled)
        np.dot(self._scaled, self._scaled.T, self._normal)
        self._diagonal += 1.0
        # lower, its upper part left as it is, in place
        self._cholesky, failed = lapack.dpotrf(self._normal.T, 1, 0, 1)
        return not failed

    def step(self, h: Array, off: Array) -> tuple[Array, Array]:
        """The step of what is carried, and of f (n,)."""
        dw = lapack.dpotrs(self._cholesky, self._LT.dot(h) + off, 1)[0]
        return dw, dw.dot(self._LT)

    def power(self, carried: Array, off: Array, change: Array) -> float:
        """dθᵀ K dθ' of a step of what is carried, off before it; `change` is dθ (n,)."""
        return float((carried - off).dot(carried))
