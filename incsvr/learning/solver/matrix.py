"""The kernel matrix as the solver needs it: in few columns, or whole where it has many.

On one velocity its rank is ten to twenty, and an iteration costs n·rank². Over several velocities the rank is near n,
and the whole matrix, of which nothing but its diagonal changes from iteration to iteration, costs a fifth of that.

Both answer the same questions. With D diagonal, w = Lᵀθ in one and f = Kθ in the other is what the interior point
carries; its step solves (I + Lᵀ D L) dw = Lᵀ h + off, or (I + K D) df = K h + off.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array, lapack


class Factored:
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


class Whole:
    """K itself (n, n)."""

    def __init__(self, kernel: Array) -> None:
        self._kernel = kernel
        self.size = kernel.shape[0]
        self._normal = np.empty_like(kernel)
        self._diagonal = self._normal.reshape(-1)[:: self.size + 1]
        self._cholesky, self._root = self._normal, np.empty(self.size)

    def product(self, theta: Array) -> Array:
        return np.asarray(self._kernel.dot(theta))

    def apart(self, theta: Array, carried: Array) -> Array:
        return np.asarray(self._kernel.dot(theta) - carried)

    def between(self, free: NDArray[np.intp], theta: Array) -> tuple[Array, Array]:
        rows = self._kernel.take(free, axis=0)
        return rows.take(free, axis=1), rows.dot(theta)

    def ridge(self, y: Array, ridge: float) -> tuple[Array, Array]:
        np.copyto(self._normal, self._kernel)
        self._diagonal += ridge
        f = y - ridge * lapack.dposv(self._normal.T, y, lower=1)[1]
        return f, f

    def weigh(self, weight: Array) -> bool:
        np.sqrt(weight, self._root)
        np.multiply(self._kernel, self._root, self._normal)
        self._normal *= self._root[:, None]
        self._diagonal += 1.0
        self._cholesky, failed = lapack.dpotrf(self._normal.T, 1, 0, 1)
        return not failed

    def step(self, h: Array, off: Array) -> tuple[Array, Array]:
        # (I + K D)⁻¹ = D^(−½) (I + D^½ K D^½)⁻¹ D^½: no difference of large numbers, however far D's spread.
        df = lapack.dpotrs(self._cholesky, self._root * (self._kernel.dot(h) + off), 1)[0]
        df /= self._root
        return df, df

    def power(self, carried: Array, off: Array, change: Array) -> float:
        return float(change.dot(carried))


Matrix = Factored | Whole
