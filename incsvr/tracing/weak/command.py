"""The command behind a noisy torque: as predicted from other blocks, so that a block's own noise is not in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from incsvr.effects import Signals
from incsvr.tracing.run import Array
from incsvr.tracing.weak.levels import as_levels, at_rest, shared
from incsvr.tracing.weak.noise import JUMP, differences
from incsvr.tracing.weak.weak_form import Blocks

ORDER = 6
"""Blocks from which a moving command is predicted."""

RECORDED = 0.2
"""Part of the torque that may stand in levels as it was recorded."""

LASTING = 1.25
"""By which levels may miss more of the torque than what is predicted: that follows a noise that lasts, too."""

LATER = 8
"""Blocks that a command must have stayed after a jump for the first of them to be told from the last."""

DRIVES = 0.5
"""Part of what the torque holds beside the command that the motion answers, below which that is noise: of thrust it
answers all."""

AFTER = 3
"""Blocks within which it would have answered most of it."""

FEWEST = 100
"""Differences from which that is told."""


@dataclass(frozen=True, slots=True)
class Command:
    """What is known of the command.

    Attributes:
        smoothed_torque: (n,) the torque without what is noise within a block, its steps kept [N m].
        predicted_torque: (n_b,) the torque of each block as predicted from earlier blocks [N m].
        stays: whether it stays between its jumps.
        levels: (n,) its levels, told from the whole run [N m]; None where it moves as it likes.
        exact: whether next to none of the torque's noise is left in them: of a level as much stays as lasts with it, if
            the command does not come back to it.
    """

    smoothed_torque: Array
    predicted_torque: Array
    stays: bool
    levels: Array | None
    exact: bool


def as_given(signals: Signals, blocks: Blocks) -> Command:
    """The command that is the torque itself: that has no noise."""
    return Command(signals.torque, blocks.mean(signals.torque), False, signals.torque, True)


def estimated_command(signals: Signals, blocks: Blocks) -> Command:
    """The command as the torque tells it: by levels where they explain it about as well as its own past does."""
    torque = blocks.mean(signals.torque)
    predicted_torque, stays = predict_torque(torque, blocks)
    stairs = as_levels(signals)
    few = np.mean(stairs == signals.torque) < RECORDED
    allowed = LASTING * _missed(torque, predicted_torque)
    levels = stairs if few and np.mean(np.abs(torque - blocks.mean(stairs))) < allowed else None
    pieces = [median_filter(signals.torque[run], blocks.size | 1, mode="nearest") for run in signals.runs()]
    smoothed_torque, again = np.concatenate(pieces), None
    if stays:
        rests = at_rest(signals, stairs)
        levels = None if levels is None else np.where(rests, 0.0, levels)
        smoothed_torque = np.where(rests, 0.0, smoothed_torque)
        predicted_torque = np.where(blocks.mean(rests.astype(np.float64)) == 1.0, 0.0, predicted_torque)
        again = None if levels is None else shared(levels)
    if again is not None:
        levels, smoothed_torque, predicted_torque = again, again, blocks.mean(again)
    return Command(smoothed_torque, predicted_torque, stays, levels, again is not None)


def predict_torque(torque: Array, blocks: Blocks) -> tuple[Array, bool]:
    """(n_b,) each block's mean torque as predicted from earlier blocks; its own where the command has just jumped.

    A command that moves is predicted by least squares from six blocks, one that stays between its jumps by the mean
    since the last: whichever misses less. The block just before is never looked at: it shares an edge, and its noise,
    with the next.

    Returns:
        the torque predicted, and whether the command stays.
    """
    position = np.arange(torque.size) - np.repeat(blocks.start[:-1], np.diff(blocks.start))
    moving = _moving(torque, position)
    limit = JUMP * 1.4826 * min(float(np.median(np.abs(torque - moving))), _usual_change(torque, position))
    staying, moving = _since_jump(torque, position, limit), np.where(np.abs(torque - moving) > limit, torque, moving)
    stays = _missed(torque, staying, limit) <= _missed(torque, moving, limit)
    return (staying if stays else moving), stays


def _missed(torque: Array, found: Array, limit: float | None = None) -> float:
    """By how much in the mean; where a block's own had to be taken, it has missed."""
    missed = np.abs(torque - found)
    own = found == torque
    most = limit if limit is not None else float(np.max(missed, initial=0.0))
    return float(np.mean(np.where(own, most, missed)))


def is_noise(blocks: Blocks, beside: Array, residual: Array) -> bool:
    """Whether what the torque holds beside the command, (n_b,), never turned the vehicle, at once or later.

    Nor where the disturbances in the water hide it: there it is little, and what an effect would make of it, less.
    Noise is in the equation's residual as it is; of thrust the motion takes its part out, that which comes late a few
    blocks later, so that it, too, is in the residual at first. What the motion answers is summed up over these blocks.
    """
    moved, left = differences(blocks, beside, 1), differences(blocks, residual, 1)
    if moved.size < FEWEST:
        return False
    late = np.stack([moved[AFTER - k : moved.size - k] for k in range(AFTER + 1)], axis=1)
    left, answered = left[AFTER:], late[:, 0] - left[AFTER:]
    calm = np.abs(left) <= JUMP * 1.4826 * float(np.median(np.abs(left))) + 1e-300
    late, answered = late[calm], answered[calm]
    normal = late.T @ late
    slopes, _, rank, _ = np.linalg.lstsq(normal, late.T @ answered, rcond=1e-10)
    if rank <= AFTER:
        return False
    noise = float(np.mean((answered - late @ slopes) ** 2))
    standard_error = float(np.sqrt(noise * np.sum(np.linalg.inv(normal))))
    return float(np.sum(slopes)) < DRIVES or standard_error > DRIVES


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


def _usual_change(torque: Array, position: NDArray[np.intp]) -> float:
    """Median change from one block to the next but one: where a command mostly stays, its noise and not its jumps."""
    change = np.abs(torque[2:] - torque[:-2])[position[2:] >= 2]
    return float(np.median(change)) if change.size else np.inf


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
            found[jumped + 1 : jumped + 3] = (total[k] - total[jumped + 4]) / (LATER - 4)
        if age < 3:
            continue
        guess = (total[k - 1] - total[jumped + 1]) / (age - 2)
        if abs(torque[k] - guess) > limit:
            jumped = k
        else:
            found[k] = guess
    return found
