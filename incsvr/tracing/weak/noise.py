"""The noise of the recordings: of gyro and torque, and which part of the equation's noise turned the vehicle."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from incsvr.signals import scales
from incsvr.tracing.run import Array, Run, sample_period, stream
from incsvr.tracing.weak.grid import despiked
from incsvr.tracing.weak.weak_form import Blocks

JUMP = 4.0
"""Deviations from what is usual beyond which the command has jumped."""

LEAP = 6.0
"""The same between samples, where a command that moves and its noise are all that is usual."""

COARSE = 0.05
"""Of the torque's deviation, added to that: less is no jump but the recording's resolution."""

QUIET = 1.5
"""Power of the torque's differences, in that of the residual's, up to which they hold noise and no command."""

UNREAD = 0.25
"""Standard error of the fraction above which it is not told: of a command that runs as fast as the blocks all is
noise."""

MOST_GYRO = 0.8
"""Part of the residual's power that may be the gyro's noise."""

LATE = 4
"""Blocks in which the thrust answers a jump of the command: what the equations do not know of that is no noise."""

FEWEST_STEADY = 60
"""Differences from which the noise's fraction is read."""


def gyro_noise(runs: Sequence[Run]) -> float:
    """Deviation of the yaw rate's white noise [rad/s], from its third differences."""
    third = np.concatenate([np.diff(stream(run, run.yaw_rate)[1], 3) for run in runs])
    return scales.white_noise(third)


def white_noise(runs: Sequence[Run]) -> float:
    """Deviation of the torque's white noise [N m], from its third differences."""
    third = np.concatenate([np.diff(despiked(stream(run, run.torque)[1]), 3) for run in runs])
    return scales.white_noise(third)


def torque_scatter(runs: Sequence[Run], block: float) -> float:
    """Deviation of the torque samples within a block of that many seconds that no motion follows [N m]."""
    period = sample_period(runs, "torque")
    return white_noise(runs) * float(np.sqrt(max(1.0 - period / block, 0.0)))


def noise_fraction(
    blocks: Blocks, torque: Array, residual: Array, gyro: Array | None = None, answer: Array | None = None,
    orders: Sequence[int] = (1, 2, 3), least_part: float = 0.0,
) -> float | None:  # fmt: skip
    """Which part of the equation's noise sits in the recorded torque, 0…1; None where it cannot be read.

    With e = n − w (torque noise n, disturbance in the water w) and both cut to their fast part by differences F, where
    no excitation is left but jumps: cov(F e, F τ)/var(F e) = var n/(var n + var w). Where the command jumps is left
    out, and what still stands out of F τ. A moving command asks for third differences; where it stays between its jumps
    first and second ones hold no command either, but less of the gyro and more of a noise that lasts. What else is in e
    lowers each reading: the largest is nearest.

    Args:
        gyro: (n_b,) a draw of what the gyro's noise does to e: it is neither n nor w, and is taken out of the variance.
        answer: (n_b,) what of the torque is a controller's answer to the rate: with the water in it, it is no noise.
        orders: of the differences.
        least_part: least part of what moves in the torque's differences that must be in the residual's: of noise all
            is, of a command next to nothing.
    """
    mean = blocks.mean(torque)
    if answer is not None:
        mean = mean - answer
    read = [_fraction_of_order(blocks, torque, mean, residual, gyro, order, least_part) for order in orders]
    return max((fraction for fraction in read if fraction is not None), default=None)


def _fraction_of_order(
    blocks: Blocks, torque: Array, mean: Array, residual: Array, gyro: Array | None, order: int, least_part: float
) -> float | None:
    """`noise_fraction` as differences of one order tell it; None where they hold the command."""
    e, t = differences(blocks, residual, order), differences(blocks, mean, order)
    calm = steady(blocks, torque, order)
    usual = [JUMP * 1.4826 * float(np.median(np.abs(x[calm]))) + 1e-12 for x in (e, t)]
    calm &= (np.abs(e) <= usual[0]) & (np.abs(t) <= usual[1])
    power = float(e[calm] @ e[calm])
    moved = float(t[calm] @ t[calm])
    # neighbouring differences share half of what they are: there are half as many
    if power <= 0.0 or (order < 3 and moved > QUIET * power) or moved > power * UNREAD**2 * np.count_nonzero(calm) / 2:
        return None
    if e[calm] @ t[calm] < least_part * moved:
        return None
    if gyro is not None:
        power -= min(float(np.sum(differences(blocks, gyro, order)[calm] ** 2)), MOST_GYRO * power)
    return float(np.clip((e[calm] @ t[calm]) / power, 0.0, 1.0))


def differences(blocks: Blocks, values: Array, order: int) -> Array:
    """Of block values, run by run."""
    return np.concatenate([np.diff(values[run], order) for run in _runs(blocks, order)])


def steady(blocks: Blocks, torque: Array, order: int) -> NDArray[np.bool_]:
    """Which differences see no jump of the command, nor a thrust that comes LATE after one.

    Where too few are left, which see no jump; all, where nearly all see one.
    """
    jumped = jumps(blocks, torque) > 0.0
    for late in (LATE, 0):
        seen = np.ones(order + 1 + late)
        calm = np.concatenate(
            [np.convolve(jumped[run], seen)[order : jumped[run].size] < 0.5 for run in _runs(blocks, order)]
        )
        if np.count_nonzero(calm) >= FEWEST_STEADY:
            return calm
    return np.ones(calm.size, dtype=bool)


def jumps(blocks: Blocks, torque: Array) -> Array:
    """(n_b,) how far the command jumps in each block; zero where it does not [N m]."""
    total = np.concatenate([[0.0], np.cumsum(leaps(torque)[0][:-1])])
    jumped = np.flatnonzero(total[np.minimum(blocks.first + blocks.size, total.size - 1)] > total[blocks.first])
    cells = np.clip(blocks.first[jumped, None] + np.arange(-1, blocks.size + 2), 0, torque.size - 1)
    far = np.zeros(len(blocks))
    far[jumped] = np.ptp(torque[cells], axis=1)
    return far


def leaps(torque: Array) -> tuple[NDArray[np.bool_], float]:
    """(n,) at which cells the command jumps, and what is usual there [N m]."""
    # a cell in which the command jumps holds a part of the jump, and so does its neighbour's difference
    step = np.zeros(torque.size)
    step[1:-1] = np.abs(torque[2:] - torque[:-2])
    # a coarse torque mostly stays where it is, and any step of its resolution would be one
    usual = LEAP * 1.4826 * float(np.median(step)) + COARSE * float(np.std(torque))
    return step > usual, usual


def _runs(blocks: Blocks, order: int) -> list[slice]:
    return [slice(int(a), int(b)) for a, b in pairwise(blocks.start) if b - a > order + 1]
