"""The dual problem of Eq. 7, solved exactly and certified; Eq. 8 beside it as the reference.

With θ = α − β the dual without bias reads: minimise D(θ) = ½ θᵀKθ + Σ εᵢ|θᵢ| − yᵀθ over |θᵢ| ≤ Cᵢ. The model is
f(x) = Σ θⱼ κ(xⱼ, x). It has no bias because no drag acts on a vehicle at rest.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from incsvr.errors import BadInput
from incsvr.learning.columns import columns
from incsvr.learning.kernel import rbf
from incsvr.learning.solver.coordinate_descent import descend
from incsvr.learning.solver.crossover import cross
from incsvr.learning.solver.duality_gap import Solution, certify
from incsvr.learning.solver.interior_point import path
from incsvr.learning.solver.matrix import Matrix
from incsvr.numerics import Array

__all__ = ["Solution", "coordinate_descent", "solve", "solve_columns"]

MAX_INPUT_NORM = 1e30
"""Root of the sum of squares of any input, at most: nothing physical is as large, and no product of two overflows."""


def solve(
    x: ArrayLike, y: ArrayLike, *, gamma: float, C: ArrayLike, epsilon: ArrayLike, vanishing: bool = False
) -> Solution:
    """Solves Eq. 7 exactly. The same input gives the same bytes.

    Args:
        x: (n,) yaw rates [rad/s], or (n, d) generalised velocities.
        y: (n,) damping [N m].
        gamma: γ of the kernel, > 0 [s²/rad²].
        C: the bound on |θᵢ| [N m], > 0; one number, or (n,) with one for each sample.
        epsilon: half the height of the tube [N m], ≥ 0; one number, or (n,).
        vanishing: with the kernel that is zero at rest (`rbf_at_rest`).

    Raises:
        BadInput: unequal lengths, a value that is not finite, a parameter out of its range, more samples than have a
            factor of bounded rank.
    """
    x, y, bound, tube = _checked(x, y, gamma, C, epsilon)
    return solve_columns(columns(x, gamma, vanishing) if y.size else np.empty((0, 0)), y, bound, tube)


def solve_columns(phi: Array, y: Array, bound: Array, tube: Array) -> Solution:
    """Solves Eq. 7 exactly for the kernel matrix φᵀφ.

    Args:
        phi: (rank, n) its columns at the samples.
        y, bound, tube: (n,) damping, Cᵢ and εᵢ [N m], finite.
    """
    best: Solution | None = None
    if (np.abs(y) > tube).any():
        matrix = Matrix(phi)
        for iterate in path(matrix, y, bound, tube):
            crossed = cross(matrix, y, bound, tube, iterate.theta, iterate.between)
            for theta in (crossed, iterate.theta):
                found = certify(theta, matrix.product(theta), y, bound, tube, iterate.number)
                if best is None or found.gap < best.gap:
                    best = found
                if found.gap <= 2.0 * found.rounding:  # nothing is left but rounding
                    return best
    if best is None:  # no samples, or all of them inside the tube around zero
        nothing = np.zeros(y.size)
        best = certify(nothing, nothing, y, bound, tube, 0)
    return best


def coordinate_descent(
    x: ArrayLike,
    y: ArrayLike,
    *,
    gamma: float,
    C: ArrayLike,
    epsilon: ArrayLike,
    start: Array | None = None,
    passes: int = 5000,
    gap: float = 1e-3,
) -> Solution:
    """Eq. 8, the paper's solver (`incsvr.learning.solver.coordinate_descent` says where the printed formula differs).

    Args:
        x, y, gamma, C, epsilon: as for `solve`.
        start: (n,) θ to start from, clipped to ±C: the weights of old vectors, zero for new samples; default zero.
        passes: at most so many passes over the samples.
        gap: stops when the duality gap is at most this part of |D(θ)|. 1e-3 still certifies only some 26 N m; the small
            change of θ by which the paper stops certifies nothing.
    """
    x, y, bound, tube = _checked(x, y, gamma, C, epsilon)
    theta = np.zeros(y.size) if start is None else np.asarray(start, dtype=np.float64)
    if theta.shape != y.shape or not np.isfinite(theta).all():
        raise BadInput(f"start has shape {theta.shape}: give one finite weight for each of the {y.size} samples")
    return descend(rbf(x, x, gamma), y, bound, tube, np.clip(theta, -bound, bound), passes, gap)


def _checked(
    x: ArrayLike, y: ArrayLike, gamma: float, C: ArrayLike, epsilon: ArrayLike
) -> tuple[Array, Array, Array, Array]:
    x, y = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    if y.ndim != 1 or x.ndim not in (1, 2) or x.shape[0] != y.size:
        raise BadInput(f"x has shape {x.shape} and y {y.shape}: give one row of x for each y")
    if not 0.0 < gamma < math.inf:
        raise BadInput(f"gamma is {gamma}: give a positive, finite number")
    bound, tube = _each("C", C, y.size), _each("epsilon", epsilon, y.size)
    for name, values in (("x", x), ("y", y), ("C", bound), ("epsilon", tube)):
        flat = values.reshape(-1)
        if not flat.dot(flat) < MAX_INPUT_NORM * MAX_INPUT_NORM:  # one call; NaN compares as false
            raise BadInput(
                f"{name} holds NaN, infinity or values beyond {MAX_INPUT_NORM:g}: strike such samples out first"
            )
    if y.size and not (float(bound.min()) > 0.0 and float(tube.min()) >= 0.0):
        raise BadInput("C must be positive and epsilon zero or more for every sample")
    return x, y, bound, tube


def _each(name: str, values: ArrayLike, n: int) -> Array:
    """One value for each of n samples."""
    array = np.asarray(values, dtype=np.float64)
    if array.ndim == 0:
        return np.full(n, array)
    if array.shape != (n,):
        raise BadInput(f"{name} has shape {array.shape}: give one number, or one for each of the {n} samples")
    return array
