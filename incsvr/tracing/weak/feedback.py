"""Whether the torque is feedback of the yaw rate: the gain of a controller.

A controller answers what the water does to the vehicle while it does it. Noise of the water then looks as if it were in
the torque, and a regressor that is made of the torque holds the noise of its own block. Why that must be in the
likelihood: U. Forssell, L. Ljung, "Closed-loop identification revisited", Automatica 35 (1999).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from incsvr.tracing.run import Array
from incsvr.tracing.weak.noise import FEWEST_STEADY, JUMP, differences, steady
from incsvr.tracing.weak.weak_form import Blocks

ORDERS = (3, 4, 5, 6, 7, 8, 10)
"""Of the differences in which a controller is looked for: the higher, the less of a smooth reference is left."""

FAR = 3.0
"""Deviations from K r beyond which the torque follows its reference and counts for nothing (Tukey's biweight)."""

STEPS = 30
"""Of reweighting, at most."""

SETTLED = 1e-3
"""Relative change of K below which reweighting ends."""

SIGNIFICANT = 4.0
"""Standard errors by which a gain must differ from none."""

REFUTED = 2.0
"""Standard errors by which the answer to the disturbances alone may fall short of it."""


STANDS = 1e-6
"""Of the torque's range: what rounding leaves of a level that is kept."""


def controller_gain(blocks: Blocks, torque: Array, rate: Array, residual: Array, inertia: float) -> float:
    """K [N m s/rad] by which the torque goes against the yaw rate, as a controller's does; 0 where it does not.

    Both are cut to their fast part by differences F, where no reference is left but jumps: these are left out. There
    the torque of an open loop is noise, and the rate knows nothing of it; what is left of a command turns the vehicle
    its own way. Only a controller opposes the rate: K = −cov(F τ, F r)/var(F r). The order counts at which that stands
    out most. While the vehicle follows a reference that has just moved, torque and rate go together: those blocks are
    far from τ = −K r, and a robust fit leaves them out (A. E. Beaton, J. W. Tukey, Technometrics 16, 1974).

    A thrust that comes late may oppose a fast command, too. A controller answers a rate whatever caused it: were the
    gain as large, the part of the rate that the residual caused must be answered with it (that part as an instrument).

    Args:
        blocks: of the equations.
        torque, rate: (n,) on the fine grid.
        residual: (n_b,) of the equations, without the effects that are known [N m].
        inertia: I₀ [kg m²].
    """
    means = blocks.mean(torque), blocks.mean(rate)
    if _stands(means[0]):
        return 0.0
    found = []
    for order in ORDERS:
        moved, rate_change = _fast(blocks, torque, means, order)
        found.append((*_opposed(moved, rate_change, order), order))
    gain, error, order = max(found, key=lambda each: each[0] / each[1])
    if gain <= SIGNIFICANT * error:
        return 0.0
    moved, rate_change, caused = _fast(blocks, torque, (*means, _caused(blocks, residual, inertia)), order)
    driven, standard_error = _answered(moved, rate_change, caused, order)
    return 0.0 if driven + REFUTED * standard_error < gain else gain


def _stands(torque: Array) -> bool:
    """Whether the torque mostly keeps its value from one block to the next: it answers no rate, for that always moves.

    Where it does, differences over many blocks hold nothing but the jumps between, which nothing is left to tell from
    an answer.
    """
    return float(np.median(np.abs(np.diff(torque)))) <= STANDS * float(np.ptp(torque))


def _fast(blocks: Blocks, torque: Array, values: Sequence[Array], order: int) -> list[Array]:
    """Differences of block values, where the command does not jump and none of them stands out; none of too few."""
    cut = [differences(blocks, each, order) for each in values]
    if cut[0].size < FEWEST_STEADY:
        return [np.zeros(0) for _ in cut]
    calm = steady(blocks, torque, order)
    for x in cut:
        calm = calm & (np.abs(x) <= JUMP * 1.4826 * float(np.median(np.abs(x[calm]))) + 1e-12)
    return [x[calm] for x in cut]


def _opposed(moved: Array, rate_change: Array, order: int) -> tuple[float, float]:
    """K as differences of torque and rate tell it, by a robust fit, and its standard error."""
    together = float(rate_change @ rate_change)
    if together <= 0.0:
        return 0.0, np.inf
    gain, weight = -float(rate_change @ moved) / together, np.ones(moved.size)
    for _ in range(STEPS):
        left = moved + gain * rate_change
        far = FAR * 1.4826 * float(np.median(np.abs(left))) + 1e-12
        weight = np.square(np.maximum(1.0 - np.square(left / far), 0.0))
        together = float((weight * rate_change) @ rate_change)
        if together <= 0.0:
            return 0.0, np.inf
        before, gain = gain, -float((weight * rate_change) @ moved) / together
        if abs(gain - before) < SETTLED * abs(gain):
            break
    root = np.sqrt(weight)
    return gain, _error(root * (moved + gain * rate_change), root * rate_change, together, order)


def _answered(moved: Array, rate_change: Array, caused: Array, order: int) -> tuple[float, float]:
    """K as the answer to what disturbances `caused` of the rate, and its standard error."""
    together = float(caused @ rate_change)
    if together <= 0.0:
        return 0.0, np.inf
    gain = -float(caused @ moved) / together
    return gain, _error(moved + gain * rate_change, caused, together, order)


def _error(left: Array, regressor: Array, together: float, order: int) -> float:
    # neighbouring differences are of the same samples: there are fewer of them than it seems
    power = float(np.mean(np.square(left))) * order
    return float(np.sqrt(power * float(regressor @ regressor))) / together + 1e-300


def _caused(blocks: Blocks, residual: Array, inertia: float) -> Array:
    """(n_b,) mean rate that disturbances −u caused; noise of the torque is in quadrature to its own part of that."""
    caused = np.zeros(residual.size)
    for begin, end in pairwise(blocks.start):
        piece = residual[begin:end]
        caused[begin:end] = -(np.cumsum(piece) - 0.5 * piece) * blocks.period / inertia
    return caused
