"""The Gaussian kernel of the model, κ(x, z) = exp(−γ ‖x − z‖²) (Section III-A)."""

from __future__ import annotations

import numpy as np

from incsvr.numerics import Array


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
