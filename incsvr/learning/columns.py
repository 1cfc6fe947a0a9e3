"""The kernel as products of few columns, κ(x, z) = φ(x)ᵀφ(z): training, curve and doubt are small products with φ.

On one vehicle's yaw rates ten to twenty columns are all there is: those of the kernel's power series. Over several
velocities, or where a kernel is narrow, the samples that a Cholesky factor pivots on give them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning.kernel import rbf, rbf_at_rest
from incsvr.numerics import Array, lapack

MAX_SERIES_ARGUMENT = 8.0
"""Argument 2γh² up to which the series is used; there it has at most 41 terms."""
SERIES_TOLERANCE = 1e-16
"""Part of κ(x, x) = 1 that is left out of the series."""
PIVOT_TOLERANCE = 2e-15
"""Part of κ(x, x) = 1 that is left out by the pivots; with less they would take up rounding."""
MAX_WHOLE_SAMPLES = 256
"""Samples up to which the kernel matrix itself is formed: at most half a megabyte."""
MAX_COLUMNS = 1024
"""Columns at most: memory stays n·MAX_COLUMNS, never n²."""


@dataclass(frozen=True, slots=True)
class Series:
    """The kernel's power series: exp(−γ(u − v)²) = Σ φₖ(u) φₖ(v) with φₖ(u) = exp(−γu²) √((2γ)ᵏ/k!) uᵏ, u = x − centre.

    For |u| ≤ h and k ≥ t = 2γh² the terms fall and the rest is of the size of the first left out, e⁻ᵗ tᵏ/k!. No terms
    cancel: their sum of absolute values is exp(−γ(|u| − |v|)²) ≤ 1.
    """

    gamma: float  # γ of the kernel
    centre: float  # of the velocities [rad/s]
    factors: Array  # (rank − 1,) √(2γ/k), each φₖ over u φₖ₋₁

    @staticmethod
    def over(low: float, high: float, gamma: float) -> Series | None:
        """The series for velocities between two; None where it has too many terms."""
        half = 0.5 * (high - low)
        t = 2.0 * gamma * half * half
        if t > MAX_SERIES_ARGUMENT:
            return None
        rank, term = 1, math.exp(-t) * t
        while term > SERIES_TOLERANCE or rank < t:
            rank += 1
            term *= t / rank
        return Series(gamma, 0.5 * (low + high), np.sqrt(2.0 * gamma / np.arange(1.0, rank)))

    def at(self, x: Array) -> Array:
        """(rank, n) φ at (n,) velocities, C-contiguous."""
        u = x - self.centre
        phi = np.empty((self.factors.size + 1, x.size))
        np.multiply(u, u, out=phi[0])
        phi[0] *= -self.gamma
        np.exp(phi[0], out=phi[0])
        np.multiply.outer(self.factors, u, out=phi[1:])
        return np.multiply.accumulate(phi, axis=0, out=phi)


@dataclass(frozen=True, slots=True)
class Pivots:
    """The columns of a Cholesky factor with diagonal pivots: φ(x) = L⁻¹ κ(pivots, x), with what they leave out of κ."""

    points: Array  # (rank,) or (rank, d) the pivots' scaled velocities
    lower: Array  # (rank, rank) L, κ of the pivots = L Lᵀ
    gamma: float  # of the kernel
    vanishing: bool

    @staticmethod
    def of(x: Array, gamma: float, vanishing: bool) -> tuple[Pivots, Array]:
        """The columns of (n,) or (n, d) velocities, n ≥ 1, and φ there (rank, n)."""
        phi, pivots = (_of_whole if x.shape[0] <= MAX_WHOLE_SAMPLES else _row_by_row)(x, gamma, vanishing)
        return Pivots(x[pivots], np.asfortranarray(phi[:, pivots].T), gamma, vanishing), phi

    def at(self, x: Array) -> Array:
        """(rank, n) φ at (n,) or (n, d) velocities."""
        return np.asarray(lapack.dtrtrs(self.lower, _kernel(self.points, x, self.gamma, self.vanishing), lower=1)[0])


def columns(x: Array, gamma: float, vanishing: bool = False) -> Array:
    """(rank, n) φ at (n,) or (n, d) velocities, n ≥ 1, with φᵀφ = K to rounding.

    Args:
        gamma: γ of the kernel.
        vanishing: of `rbf_at_rest` in place of `rbf`.

    Raises:
        BadInput: more than `MAX_COLUMNS` samples of which each is a column of its own.
    """
    series = Series.over(float(x.min()), float(x.max()), gamma) if x.ndim == 1 and not vanishing else None
    return Pivots.of(x, gamma, vanishing)[1] if series is None else series.at(x)


def _kernel(x: Array, z: Array, gamma: float, vanishing: bool) -> Array:
    return rbf_at_rest(x, z, gamma) if vanishing else rbf(x, z, gamma)


def _of_whole(x: Array, gamma: float, vanishing: bool) -> tuple[Array, Array]:
    """φ (rank, n) and the pivots (rank,), of the kernel matrix."""
    lower, pivots, rank, _ = lapack.dpstrf(_kernel(x, x, gamma, vanishing), tol=PIVOT_TOLERANCE, lower=1)
    phi = np.empty((rank, x.shape[0]))
    phi[:, pivots - 1] = np.tril(lower[:, :rank]).T
    return phi, pivots[:rank] - 1


def _row_by_row(x: Array, gamma: float, vanishing: bool) -> tuple[Array, Array]:
    """φ (rank, n) and the pivots (rank,), of which each computes its row of the kernel matrix when it is chosen."""
    n = x.shape[0]
    phi, pivots = np.empty((16, n)), list[int]()
    left = np.ones(n)
    if vanishing:
        left -= rbf(np.zeros_like(x[:1]), x, gamma)[0] ** 2
    for rank in range(n):
        pivot = int(left.argmax())
        if left[pivot] <= PIVOT_TOLERANCE:
            break
        if rank == MAX_COLUMNS:
            raise BadInput(
                f"{n} samples with gamma = {gamma:g} lie too far apart to be solved together "
                f"(rank over {MAX_COLUMNS}): lower gamma or take at most {MAX_COLUMNS} samples"
            )
        if rank == phi.shape[0]:
            phi = np.concatenate([phi, np.empty((min(rank, MAX_COLUMNS - rank, n - rank), n))])
        row = _kernel(x[pivot : pivot + 1], x, gamma, vanishing)[0]
        row -= phi[:rank, pivot] @ phi[:rank]
        row /= math.sqrt(left[pivot])
        phi[rank] = row
        left -= row * row
        left[pivot] = 0.0
        pivots.append(pivot)
    return phi[: len(pivots)], np.array(pivots, dtype=np.intp)
