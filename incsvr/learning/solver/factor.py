"""The kernel matrix as a product of few columns, K = L Lᵀ: on one vehicle's yaw rates its rank is ten to twenty."""

from __future__ import annotations

import math

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning.kernel import rbf
from incsvr.numerics import Array, lapack

MAX_WHOLE_SAMPLES = 256
"""Samples up to which the kernel matrix itself is formed: at most half a megabyte."""
MAX_COLUMNS = 1024
"""Columns of L at most: memory stays n·MAX_COLUMNS, never n²."""
MAX_SERIES_ARGUMENT = 8.0
"""Argument 2γh² up to which the series is used; there it has at most 41 terms."""
SERIES_TOLERANCE = 1e-16
"""Part of κ(x, x) = 1 that is left out of the series."""
PIVOT_TOLERANCE = 2e-15
"""Part of κ(x, x) = 1 that is left out by the pivots; with less they would take up rounding."""


def factor(x: Array, gamma: float, vanishing: bool = False) -> Array:
    """Lᵀ of shape (rank, n), C-contiguous, with L Lᵀ = K to rounding; memory is n·rank.

    Args:
        x: (n,) or (n, d), n ≥ 1.
        gamma: γ of the kernel.
        vanishing: of `rbf_at_rest` in place of `rbf`.

    Raises:
        BadInput: more than `MAX_COLUMNS` samples of which each is a column of its own.
    """
    if x.ndim == 1 and not vanishing:
        low, high = float(x.min()), float(x.max())
        if 0.5 * gamma * (high - low) ** 2 <= MAX_SERIES_ARGUMENT:
            return _series(x - 0.5 * (low + high), gamma, 0.5 * (high - low))
    return _pivoted(x, gamma, vanishing)


def _series(u: Array, gamma: float, half: float) -> Array:
    """The kernel's power series: exp(−γ(u − v)²) = Σ φₖ(u) φₖ(v) with φₖ(u) = exp(−γu²) √((2γ)ᵏ/k!) uᵏ.

    For |u| ≤ h and k ≥ t = 2γh² the terms fall and the rest is of the size of the first left out, e⁻ᵗ tᵏ/k!. No terms
    cancel: their sum of absolute values is exp(−γ(|u| − |v|)²) ≤ 1.
    """
    t = 2.0 * gamma * half * half
    rank, term = 1, math.exp(-t) * t
    while term > SERIES_TOLERANCE or rank < t:
        rank += 1
        term *= t / rank
    LT = np.empty((rank, u.size))
    np.multiply(u, u, out=LT[0])
    LT[0] *= -gamma
    np.exp(LT[0], out=LT[0])
    np.multiply.outer(np.sqrt(2.0 * gamma / np.arange(1.0, rank)), u, out=LT[1:])
    return np.multiply.accumulate(LT, axis=0, out=LT)


def _pivoted(x: Array, gamma: float, vanishing: bool) -> Array:
    """Cholesky with diagonal pivots; beyond `MAX_WHOLE_SAMPLES` samples K's rows are computed one by one as pivots
    need them.

    What vanishes at rest is the kernel with the origin as its first pivot.
    """
    n = x.shape[0]
    rest = rbf(np.zeros_like(x[:1]), x, gamma)[0] if vanishing else None
    if n <= MAX_WHOLE_SAMPLES:
        kernel = rbf(x, x, gamma)
        if rest is not None:
            kernel -= np.multiply.outer(rest, rest)
        lower, pivots, rank, _ = lapack.dpstrf(kernel, tol=PIVOT_TOLERANCE, lower=1)
        LT = np.empty((rank, n))
        LT[:, pivots - 1] = np.tril(lower[:, :rank]).T
        return LT
    LT = np.empty((16, n))
    left = np.ones(n) if rest is None else 1.0 - rest * rest
    for rank in range(n):
        pivot = int(left.argmax())
        if left[pivot] <= PIVOT_TOLERANCE:
            return LT[:rank]
        if rank == MAX_COLUMNS:
            raise BadInput(
                f"{n} samples with gamma = {gamma:g} lie too far apart to be solved together "
                f"(rank over {MAX_COLUMNS}): lower gamma or take at most {MAX_COLUMNS} samples"
            )
        if rank == LT.shape[0]:
            LT = np.concatenate([LT, np.empty((min(rank, MAX_COLUMNS - rank, n - rank), n))])
        row = rbf(x[pivot : pivot + 1], x, gamma)[0]
        if rest is not None:
            row -= rest[pivot] * rest
        row -= LT[:rank, pivot] @ LT[:rank]
        row /= math.sqrt(left[pivot])
        LT[rank] = row
        left -= row * row
        left[pivot] = 0.0
    return LT
