"""The dual problem of Eq. 7, solved exactly and certified; Eq. 8 beside it as the reference.

With θ = α − β the dual without bias reads: minimise D(θ) = ½ θᵀKθ + Σ εᵢ|θᵢ| − yᵀθ over |θᵢ| ≤ Cᵢ. The model is
f(x) = Σ θⱼ κ(xⱼ, x). It has no bias because no drag acts on a vehicle at rest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from incsvr.errors import BadInput
from incsvr.learning.interior_point import cross, path
from incsvr.learning.kernel import columns, rbf
from incsvr.numerics import Array

MAX_INPUT_NORM = 1e30
"""Root of the sum of squares of any input, at most: nothing physical is as large, and no product of two overflows."""
ROUNDING_SHARE = 8.0 * float(np.finfo(np.float64).eps)
"""Part of ‖θ‖ and of f that rounding takes a value of f = Kθ away at most, a sum of n products and the kernel's own
rounding. In seventy thousand fuzzed cases the true gap, computed with more digits, took four fifths of this allowance
at most."""


@dataclass(frozen=True, slots=True)
class Solution:
    """A solution of Eq. 7 and what is certain about it."""

    weight: Array  # (n,) θ = α − β [N m]
    fitted: Array  # (n,) f(xᵢ), the model at the samples [N m]
    gap: float  # the duality gap P(f) + D(θ) ≥ 0, with `rounding` added [(N m)²]
    rounding: float  # what the rounding of f can hide of the gap [(N m)²]
    certified_error: float  # |f(x) − f*(x)| is at most this at every x [N m]; f* is the model of the exact solution
    objective: float  # D(θ), which Eq. 7 minimises [(N m)²]
    iterations: int  # iterations of the interior point, or passes of Eq. 8


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
        for iterate in path(phi, y, bound, tube):
            for theta in (cross(phi, y, bound, tube, iterate), iterate.theta):
                found = certify(theta, phi.dot(theta).dot(phi), y, bound, tube, iterate.number)
                if best is None or found.gap < best.gap:
                    best = found
                if found.gap <= 2.0 * found.rounding:  # nothing is left but rounding
                    return best
    if best is None:  # no samples, or all of them inside the tube around zero
        nothing = np.zeros(y.size)
        best = certify(nothing, nothing, y, bound, tube, 0)
    return best


def certify(theta: Array, f: Array, y: Array, bound: Array, tube: Array, iterations: int) -> Solution:
    """The duality gap of θ and the bound on the model's error that follows.

    The primal of Eq. 7 is P(f) = ½‖f‖² + Σ Cᵢ max(0, |yᵢ − fᵢ| − εᵢ). P(f) + D(θ) falls apart into one term for each
    sample, none of them negative. Each is computed in a form without cancellation: where C·n is large, P and −D agree
    in so many digits that their difference would be noise. D is strongly convex in the norm of the kernel's space, so
    ‖f − f*‖² ≤ 2·gap; κ(x, x) = 1 there, hence sup|f − f*| ≤ √(2·gap).

    Args:
        theta: (n,) with |θᵢ| ≤ Cᵢ [N m].
        f: (n,) Kθ, the model at the samples [N m].
        y, bound, tube: (n,) damping, Cᵢ and εᵢ [N m].
        iterations: passed on.
    """
    residual, size = y - f, np.abs(theta)
    slack = bound - size
    outside = np.maximum(np.abs(residual) - tube, 0.0)
    along = np.copysign(1.0, theta) * residual - tube
    gap = float(slack.dot(outside) + size.dot(outside - along))
    # How steep each term is in f, which rounding has moved: not at all for a sample on its bound and outside the tube.
    moved = ROUNDING_SHARE * (math.sqrt(float(theta.dot(theta))) + float(np.abs(f).max(initial=0.0)))
    steep = np.where(np.abs(along) <= moved, bound, np.where(along > 0.0, slack, size))
    rounding = moved * float(steep.sum())
    gap += rounding
    objective = float(0.5 * theta.dot(f) + tube.dot(size) - y.dot(theta))
    return Solution(theta, f, gap, rounding, math.sqrt(2.0 * gap), objective, iterations)


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
    """Passes of Eq. 8, the paper's solver, until the duality gap is at most `gap`·|D(θ)| or nothing changes any more.

    The derivatives of the dual (7) are ∂D/∂αⱼ = ε − yⱼ + f(xⱼ) and ∂D/∂βⱼ = ε + yⱼ − f(xⱼ), so a descent must read

        αⱼ ← clip(αⱼ − (ε − yⱼ + f(xⱼ)) / κ(xⱼ, xⱼ), 0, C),    βⱼ ← clip(βⱼ − (ε + yⱼ − f(xⱼ)) / κ(xⱼ, xⱼ), 0, C).

    Eq. 8 as printed has ε + y − f in the line of α and ε − y + f in that of β: the two are exchanged, and passes with
    them walk away from the solution. The new αⱼ counts before βⱼ is computed, and κ(xⱼ, xⱼ) = 1.

    Args:
        x, y, gamma, C, epsilon: as for `solve`.
        start: (n,) θ to start from, clipped to ±C: the weights of old vectors, zero for new samples; default zero.
        passes: at most so many passes over the samples.
        gap: 1e-3 still certifies only some 26 N m; the small change of θ by which the paper stops certifies nothing.
    """
    x, y, bound, tube = _checked(x, y, gamma, C, epsilon)
    theta = np.zeros(y.size) if start is None else np.asarray(start, dtype=np.float64)
    if theta.shape != y.shape or not np.isfinite(theta).all():
        raise BadInput(f"start has shape {theta.shape}: give one finite weight for each of the {y.size} samples")
    theta, K = np.clip(theta, -bound, bound), rbf(x, x, gamma)
    alpha, beta = np.maximum(theta, 0.0).tolist(), np.maximum(-theta, 0.0).tolist()
    f = K @ theta
    samples = list(zip(range(y.size), (y - tube).tolist(), (y + tube).tolist(), bound.tolist(), K, strict=True))
    solution = certify(theta, f, y, bound, tube, 0)
    for done in range(1, passes + 1):
        change = 0.0
        for j, lower, upper, limit, row in samples:
            f_j, a, b = f.item(j), alpha[j], beta[j]
            alpha[j] = min(max(a + lower - f_j, 0.0), limit)
            beta[j] = min(max(b - upper + f_j + alpha[j] - a, 0.0), limit)
            step = alpha[j] - a - beta[j] + b
            if step != 0.0:
                f += step * row
                change = max(change, abs(step))
        if change == 0.0 or done % 20 == 0 or done == passes:
            theta = np.subtract(alpha, beta)
            f = K @ theta  # anew: thousands of small steps leave rounding behind
            solution = certify(theta, f, y, bound, tube, done)
            if change == 0.0 or solution.gap <= gap * abs(solution.objective):
                break
    return solution


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
        if not float(np.vdot(values, values)) < MAX_INPUT_NORM**2:  # one call; NaN compares as false
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
