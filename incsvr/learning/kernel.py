"""The Gaussian kernel of the model, κ(x, z) = exp(−γ ‖x − z‖²) (Section III-A), and its few columns φ.

κ(x, z) = φ(x)ᵀφ(z): training, curve and doubt are small products with φ. On one vehicle's yaw rates ten to twenty
columns are all there is: those of the kernel's power series. Over several velocities, or where a kernel is narrow, the
samples that a Cholesky factor pivots on give them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array, lapack

MAX_SERIES_ARGUMENT = 8.0
"""Argument 2γh² up to which the series is used; there it has at most 41 terms."""
SERIES_TOLERANCE = 1e-16
"""Part of κ(x, x) = 1 that is left out of the series."""
PIVOT_TOLERANCE = 2e-15
"""Part of κ(x, x) = 1 that is left out by the pivots; with less they would take up rounding."""
MAX_SAMPLES = 2048
"""Samples of which a kernel matrix is formed, at most: it takes thirty megabytes."""


def rbf(x: Array, z: Array, gamma: float) -> Array:
    """κ(xᵢ, zⱼ) = exp(−γ ‖xᵢ − zⱼ‖²).

    Args:
        x: (n,) yaw rates [rad/s], or (n, d) generalised velocities.
        z: (m,) or (m, d), likewise.
        gamma: γ > 0 [s²/rad²]; κ falls to 1/e at a distance of 1/√γ.

    Returns:
        (n, m), each in [0, 1] and exactly 1 where xᵢ = zⱼ.

    Example:
        >>> rbf(np.array([0.0, 0.1]), np.array([0.1]), gamma=10.0).round(3).tolist()
        [[0.905], [1.0]]
    """
    if x.ndim == 1:
        exponent = np.subtract.outer(x, z)
        exponent *= exponent
    else:
        # Differences coordinate by coordinate: ‖x‖² + ‖z‖² − 2 xᵀz would cancel where points lie close together.
        exponent = np.zeros((x.shape[0], z.shape[0]))
        for x_k, z_k in zip(x.T, z.T, strict=True):
            difference = np.subtract.outer(x_k, z_k)
            difference *= difference
            exponent += difference
    exponent *= -gamma
    np.exp(exponent, out=exponent)
    return exponent


def rbf_at_rest(x: Array, z: Array, gamma: float) -> Array:
    """κ(xᵢ, zⱼ) − κ(xᵢ, 0) κ(0, zⱼ): every sum of these is zero where all velocities are, and nothing else is asked.

    It is the Gaussian process of `rbf` once it is known that f(0) = 0 (Rasmussen and Williams, 2006, Eq. 2.24), so that
    it is a kernel, and at most 1.

    Args:
        x, z: (n, d) and (m, d) scaled velocities.
        gamma: as in `rbf`.
    """
    rest = np.zeros_like(x[:1], shape=(1, *x.shape[1:]))
    return np.asarray(rbf(x, z, gamma) - rbf(x, rest, gamma) * rbf(rest, z, gamma))


def rbf_at_rest_slope(x: Array, z: Array, gamma: float) -> Array:
    """(n, m) derivative of `rbf_at_rest` with respect to the first coordinate of x, with its arguments."""
    rest = np.zeros_like(x[:1])
    near = np.subtract.outer(x[:, 0], z[:, 0]) * rbf(x, z, gamma)
    return np.asarray(-2.0 * gamma * (near - x[:, :1] * rbf(x, rest, gamma) * rbf(rest, z, gamma)))


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
        """The columns of (n,) or (n, d) velocities, n ≥ 1, and φ there (rank, n).

        Raises:
            BadInput: more than `MAX_SAMPLES` of them.
        """
        if x.shape[0] > MAX_SAMPLES:
            raise BadInput(
                f"{x.shape[0]} samples with gamma = {gamma:g} lie too far apart to be solved together: lower gamma or "
                f"take at most {MAX_SAMPLES} samples"
            )
        lower, pivots, rank, _ = lapack.dpstrf(_kernel(x, x, gamma, vanishing), tol=PIVOT_TOLERANCE, lower=1)
        phi = np.empty((rank, x.shape[0]))
        phi[:, pivots - 1] = np.tril(lower[:, :rank]).T
        pivots = pivots[:rank] - 1
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
        BadInput: more than `MAX_SAMPLES` samples where the series has too many terms.
    """
    series = Series.over(float(x.min()), float(x.max()), gamma) if x.ndim == 1 and not vanishing else None
    return Pivots.of(x, gamma, vanishing)[1] if series is None else series.at(x)


def _kernel(x: Array, z: Array, gamma: float, vanishing: bool) -> Array:
    return rbf_at_rest(x, z, gamma) if vanishing else rbf(x, z, gamma)
