"""Eq. 8 of the paper: coordinate descent on the dual, sample by sample; the reference of the exact solver."""

from __future__ import annotations

import numpy as np

from incsvr.learning.solver.duality_gap import Solution, certify
from incsvr.numerics import Array

PASSES_PER_LOOK = 20
"""Passes between two looks at the duality gap."""


def descend(K: Array, y: Array, bound: Array, tube: Array, start: Array, passes: int, gap: float) -> Solution:
    """Passes of Eq. 8 from `start`, until the duality gap is at most `gap`·|D(θ)| or nothing changes any more.

    The derivatives of the dual (7) are ∂D/∂αⱼ = ε − yⱼ + f(xⱼ) and ∂D/∂βⱼ = ε + yⱼ − f(xⱼ), so a descent must read

        αⱼ ← clip(αⱼ − (ε − yⱼ + f(xⱼ)) / κ(xⱼ, xⱼ), 0, C),    βⱼ ← clip(βⱼ − (ε + yⱼ − f(xⱼ)) / κ(xⱼ, xⱼ), 0, C).

    Eq. 8 as printed has ε + y − f in the line of α and ε − y + f in that of β: the two are exchanged, and passes with
    them walk away from the solution. The new αⱼ counts before βⱼ is computed, and κ(xⱼ, xⱼ) = 1.
    """
    alpha, beta = np.maximum(start, 0.0).tolist(), np.maximum(-start, 0.0).tolist()
    f = K @ start
    samples = list(zip(range(y.size), (y - tube).tolist(), (y + tube).tolist(), bound.tolist(), K, strict=True))
    solution = certify(start, f, y, bound, tube, 0)
    for done in range(1, passes + 1):
        change = 0.0
        for j, lower, upper, limit, row in samples:
            f_j = f.item(j)
            a, b = alpha[j], beta[j]
            new_a = a + lower - f_j
            new_a = 0.0 if new_a < 0.0 else limit if new_a > limit else new_a
            new_b = b - upper + f_j + new_a - a
            new_b = 0.0 if new_b < 0.0 else limit if new_b > limit else new_b
            if new_a != a or new_b != b:
                alpha[j], beta[j] = new_a, new_b
                step = new_a - a - new_b + b
                f += step * row
                change = max(change, abs(step))
        if change == 0.0 or done % PASSES_PER_LOOK == 0 or done == passes:
            theta = np.subtract(alpha, beta)
            f = K @ theta  # anew: thousands of small steps leave rounding behind
            solution = certify(theta, f, y, bound, tube, done)
            if change == 0.0 or solution.gap <= gap * abs(solution.objective):
                break
    return solution
