"""The noise of the recordings: of gyro and torque, and which part of the equation's noise turned the vehicle."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from incsvr.effects import Signals
from incsvr.tracer.run import Array, Run, sample_period, stream
from incsvr.tracer.weak_form import Blocks, despiked, scatter

JUMP = 4.0
"""Deviations from what is usual beyond which the command has jumped."""

LEAP = 6.0
"""The same between samples, where a command that moves and its noise are all that is usual."""

COARSE = 0.05
"""Of the torque's deviation, added to that: less is no jump but the recording's resolution."""

QUIET = 1.5
"""Power of the torque's differences, in that of the residual's, up to which they hold noise and no command."""

UNREAD = 0.25
"""Standard error of the share above which it is not told: of a command that runs as fast as the blocks all is noise."""

MOST_GYRO = 0.8
"""Part of the residual's power that may be the gyro's noise."""

FEWEST_STEADY = 60
"""Differences from which the noise's share is read."""


def gyro_noise(runs: Sequence[Run]) -> float:
    """Deviation of the yaw rate's white noise [rad/s], from its third differences."""
    third = np.concatenate([np.diff(stream(run, run.yaw_rate)[1], 3) for run in runs])
    return scatter(third)


def white_noise(runs: Sequence[Run]) -> float:
    """Deviation of the torque's white noise [N m], from its third differences."""
    third = np.concatenate([np.diff(despiked(stream(run, run.torque)[1]), 3) for run in runs])
    return scatter(third)


def torque_scatter(runs: Sequence[Run], block: float) -> float:
    """Deviation of the torque samples within a block of that many seconds that no motion follows [N m]."""
    period = sample_period(runs, "torque")
    return white_noise(runs) * float(np.sqrt(max(1.0 - period / block, 0.0)))


def noise_share(
    blocks: Blocks, torque: Array, residual: Array, gyro: Array | None = None, answer: Array | None = None
) -> float | None:
    """Which part of the equation's noise sits in the recorded torque, 0…1; None where it cannot be read.

    With e = n − w (torque noise n, disturbance in the water w) and both cut to their fast part by differences F, where
    no excitation is left but jumps: cov(F e, F τ)/var(F e) = var n/(var n + var w). Where the command jumps is left
    out, and what still stands out of F τ. A moving command asks for third differences; where it stays between its jumps
    first and second ones hold no command either, but less of the gyro and more of a noise that lasts. What else is in e
    lowers each reading: the largest is nearest.

    Args:
        gyro: (n_b,) a draw of what the gyro's noise does to e: it is neither n nor w, and is taken out of the variance.
        answer: (n_b,) what of the torque is a controller's answer to the rate: with the water in it, it is no noise.
    """
    mean = blocks.mean(torque)
    if answer is not None:
        mean = mean - answer
    read = [_share(blocks, torque, mean, residual, gyro, order) for order in (1, 2, 3)]
    return max((share for share in read if share is not None), default=None)


def _share(blocks: Blocks, torque: Array, mean: Array, residual: Array, gyro: Array | None, order: int) -> float | None:
    """`noise_share` as differences of one order tell it; None where they hold the command."""
    e, t = differences(blocks, residual, order), differences(blocks, mean, order)
    calm = steady(blocks, torque, order)
    usual = [JUMP * 1.4826 * float(np.median(np.abs(x[calm]))) + 1e-12 for x in (e, t)]
    calm &= (np.abs(e) <= usual[0]) & (np.abs(t) <= usual[1])
    power = float(e[calm] @ e[calm])
    moved = float(t[calm] @ t[calm])
    # neighbouring differences share half of what they are: there are half as many
    if power <= 0.0 or (order < 3 and moved > QUIET * power) or moved > power * UNREAD**2 * np.count_nonzero(calm) / 2:
        return None
    if gyro is not None:
        power -= min(float(np.sum(differences(blocks, gyro, order)[calm] ** 2)), MOST_GYRO * power)
    return float(np.clip((e[calm] @ t[calm]) / power, 0.0, 1.0))


def differences(blocks: Blocks, values: Array, order: int) -> Array:
    """Of block values, run by run."""
    return np.concatenate([np.diff(values[run], order) for run in _runs(blocks, order)])


def steady(blocks: Blocks, torque: Array, order: int) -> NDArray[np.bool_]:
    """Which differences see no jump of the command; all, where nearly all see one."""
    # a cell in which the command jumps holds a part of the jump, and so does its neighbour's difference
    step = np.abs(torque[2:] - torque[:-2])
    usual = 1.4826 * float(np.median(step))
    # a coarse torque mostly stays where it is, and any step of its resolution would be one
    total = np.concatenate([[0.0, 0.0], np.cumsum(step > LEAP * usual + COARSE * float(np.std(torque)))])
    jumped = total[np.minimum(blocks.first + blocks.size, total.size - 1)] > total[blocks.first]
    calm = np.concatenate([np.convolve(jumped[run], np.ones(order + 1), "valid") < 0.5 for run in _runs(blocks, order)])
    return calm if np.count_nonzero(calm) >= FEWEST_STEADY else np.ones(calm.size, dtype=bool)


def _runs(blocks: Blocks, order: int) -> list[slice]:
    return [slice(int(a), int(b)) for a, b in pairwise(blocks.start) if b - a > order + 1]


def calmed(signals: Signals, size: int) -> Array:
    """(n,) running median of the torque over a block."""
    pieces = [median_filter(signals.torque[run], size | 1, mode="nearest") for run in signals.runs()]
    return np.concatenate(pieces)


def foretell(torque: Array, blocks: Blocks, stays: bool | None = None) -> tuple[Array, bool]:
    """(n_b,) each block's mean torque as foretold from earlier blocks; its own where the command has just jumped.

    A command that moves is foretold by least squares from six blocks, one that stays between its jumps by the mean
    since the last: whichever misses less. The block just before is never looked at: it shares an edge, and its noise,
    with the next.

    Args:
        stays: whether the command stays between its jumps, where that is known.

    Returns:
        the torque foretold, and whether the command stays.
    """
    position = np.arange(torque.size) - np.repeat(blocks.start[:-1], np.diff(blocks.start))
    moving = _moving(torque, position)
    limit = JUMP * 1.4826 * float(np.median(np.abs(torque - moving)))
    staying, moving = _since_jump(torque, position, limit), np.where(np.abs(torque - moving) > limit, torque, moving)

    def missed(found: Array) -> float:
        # where a block's own had to be taken, it has missed
        return float(np.mean(np.where(found == torque, limit, np.abs(torque - found))))

    stays = missed(staying) <= missed(moving) if stays is None else stays
    return (staying if stays else moving), stays


ORDER = 6
"""Blocks from which a moving command is foretold."""

LATER = 8
"""Blocks that a command must have stayed after a jump for the first of them to be told from the last."""


def _moving(torque: Array, position: NDArray[np.intp]) -> Array:
    """(n_b,) by least squares from earlier blocks; with jumps in the fit a part of one would be expected always."""
    guess = torque.copy()
    usable = np.flatnonzero(position > ORDER)
    if not usable.size:
        return guess
    past = np.stack([torque[usable - k] for k in range(2, ORDER + 2)], axis=1)
    ridge = (1e-6 * float(np.sum(past**2)) + 1e-300) * np.eye(ORDER)
    steady = np.ones(usable.size, dtype=bool)
    for _ in range(4):
        weights = np.linalg.solve(past[steady].T @ past[steady] + ridge, past[steady].T @ torque[usable[steady]])
        missed = np.abs(torque[usable] - past @ weights)
        steady = missed <= JUMP * 1.4826 * float(np.median(missed))
    guess[usable] = past @ weights
    return guess


def _since_jump(torque: Array, position: NDArray[np.intp], limit: float) -> Array:
    """(n_b,) the mean since the last jump; of a jump the block's own."""
    total = np.concatenate([[0.0], np.cumsum(torque)])
    found = torque.copy()
    jumped = 0
    for k in range(torque.size):
        if position[k] == 0:
            jumped = k
        age = k - jumped
        if age == LATER:
            # the first two blocks after a jump have none before them: they are told from those a little later
            found[jumped + 1 : jumped + 3] = (total[k + 1] - total[jumped + 4]) / (LATER - 3)
        if age < 3:
            continue
        guess = (total[k - 1] - total[jumped + 1]) / (age - 2)
        if abs(torque[k] - guess) > limit:
            jumped = k
        else:
            found[k] = guess
    return found
