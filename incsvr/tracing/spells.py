"""Is what a model leaves one stationary disturbance, or is it loud in spells?

A clock that steps, thrusters that were off, a gyro that stands still: each makes the residual large for a while. Water
does not come and go like that, unless the sea changes; either way the model does not hold throughout.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from incsvr.model.fitting import DEGREES
from incsvr.numerics import Array, robust_deviation

PERMUTED_NEIGHBOURS = 4
"""Neighbouring innovations that a permutation keeps together: what is left of their correlation."""


def spells(
    innovation: Array,
    moves: Array,
    per_scale: float,
    seed: int = 0,
    # Time scales over which loudness is averaged: shorter than a pause of the thrusters, longer than what the noise's
    # own correlation leaves.
    window: float = 6.0,
    permutations: int = 999,  # of which chance is told: a p-value of a thousandth can be seen
    most: int = 4000,  # innovations that are looked at; of more, means over neighbours
    p_value: float = 0.005,  # the largest of a residual that is called one disturbance no more
    louder: float = 1.5,  # deviation within, over that outside: a sea that is a little rougher does not matter
) -> NDArray[np.bool_]:
    """(n,) which innovations lie in a spell, where there are more of these than chance would have it; else none.

    The variance of the mean loudness log(1 + z²/6) over windows, against the same of permuted blocks: white noise of
    one size has no loudness that lasts.

    Args:
        innovation: (n,) of the residual, white.
        moves: (n, k) what makes the equation's own error larger, such as how fast torque and rate change: what these
            explain of the loudness is no spell.
        per_scale: innovations in a time scale of the motion.
    """
    nowhere = np.zeros(innovation.size, dtype=bool)
    usual = robust_deviation(innovation)
    many = max(innovation.size // most, 1)
    n, length = innovation.size // many, max(round(window * per_scale / many), 2 * PERMUTED_NEIGHBOURS)
    if n < 4 * length or usual <= 0.0:
        return nowhere
    loudness = np.log1p((innovation / usual) ** 2 / DEGREES)
    usual_moves = np.median(np.abs(moves), axis=0) + 1e-300
    design = np.column_stack([np.ones(innovation.size), np.log1p(np.abs(moves) / usual_moves)])
    loudness = loudness - design @ np.linalg.lstsq(design, loudness)[0]
    loudness = loudness[: n * many].reshape(n, many).mean(axis=1)
    loudness = loudness / max(float(np.std(loudness)), 1e-300)
    random = np.random.default_rng(seed)
    folded = loudness[: n // PERMUTED_NEIGHBOURS * PERMUTED_NEIGHBOURS].reshape(-1, PERMUTED_NEIGHBOURS)
    chance = [_variance(folded[random.permutation(len(folded))].ravel(), length) for _ in range(permutations)]
    if (1 + np.sum(np.array(chance) >= _variance(loudness, length))) / (permutations + 1) > p_value:
        return nowhere
    short = max(length // 3, PERMUTED_NEIGHBOURS)
    local = np.convolve(loudness, np.full(short, 1.0 / np.sqrt(short)), "same")
    in_spell = nowhere.copy()
    # a spell is where the loudness is above half its height
    within = local > 0.5 * (float(np.quantile(local, 0.1)) + float(np.max(local)))
    in_spell[: n * many] = np.repeat(_without_gaps(within, length), many)
    inside, outside = innovation[in_spell], innovation[~in_spell]
    if not inside.size or not outside.size:  # what comes and goes all the time is no spell
        return nowhere
    return in_spell if float(np.std(inside)) > louder * float(np.std(outside)) else nowhere


def sentence(
    found: Sequence[tuple[float, float]],
    most: int = 5,  # that are named
) -> str:
    """The sentence on spells, for people."""
    where = ", ".join(f"{a:.4g}–{b:.4g} s" for a, b in found[:most])
    more = f" and {len(found) - most} more" if len(found) > most else ""
    return (
        f"the residual is unusually large at {where}{more}; check the clocks of both streams, arming and the gyro there"
    )


def _variance(values: Array, length: int) -> float:
    """Variance of the means over all windows of a length, in that of white noise."""
    total = np.concatenate([[0.0], np.cumsum(values)])
    return float(np.mean((total[length:] - total[:-length]) ** 2)) / length


def _without_gaps(inside: NDArray[np.bool_], length: int) -> NDArray[np.bool_]:
    """The mask with gaps shorter than `length` closed."""
    found = inside.copy()
    at = np.flatnonzero(inside)
    for a, b in pairwise(at.tolist()):
        if 1 < b - a < length:
            found[a:b] = True
    return found


def spans(time: Array, inside: NDArray[np.bool_], period: float) -> tuple[tuple[float, float], ...]:
    """First and last instant of each spell [s], rounded; `time` begins each block of length `period`.

    A spell ends where the time goes back, as from one recording to the next.
    """
    on = np.diff(time, prepend=np.inf) > 0.0
    begins = inside & ~(np.concatenate([[False], inside[:-1]]) & on)
    ends = inside & ~np.concatenate([inside[1:] & on[1:], [False]])
    return tuple(
        (round(float(a), 2), round(float(b) + period, 2)) for a, b in zip(time[begins], time[ends], strict=True)
    )
