"""A command that stays between its jumps: its levels, told from the torque's noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from incsvr.effects import Signals
from incsvr.tracing.run import Array
from incsvr.tracing.weak.noise import COARSE, LEAP, leaps

WIDEST = 4
"""Cells that a single jump touches at most: of more, which hold several, the torque is taken as it is."""

FEW = 5
"""Cells before and after it by whose means a jump is told that no two cells tell."""

REST = 3.0
"""Deviations of the mean of its noise, below which a level is none."""

CROWD = 3.0
"""Deviations by which more than half of the stays so near to nothing must be half as near: even ones are half."""

MOST_LEVELS = 9
"""That a command may come back to."""

VISITS = 6
"""Stays at each, in the mean, from which levels are told to be the same."""

APART = 0.15
"""Deviation of the stays from the levels that they share, in parts of the least distance of two: of commands that take
any level it is above 0.25, however many they are cut into."""

CELLS = 200
"""Over which the stays are counted."""


def at_rest(signals: Signals, levels: Array) -> NDArray[np.bool_]:
    """(n,) where the command stays as near to nothing as its noise alone may bring it: there it asks for nothing.

    Told, a rest would hold the mean of its noise, and a dead band that takes it would explain the equation and the run.
    A command that rests does so again and again: its stays crowd at nothing, small levels of any other spread evenly.
    """
    edges = np.flatnonzero(np.diff(levels, prepend=np.nan, append=np.nan) != 0.0)
    length = np.repeat(np.diff(edges), np.diff(edges))
    noise = (signals.torque - levels)[length > WIDEST]
    if noise.size < 2 or not noise.any():
        return np.zeros(levels.size, dtype=bool)
    memory = float(np.clip(noise[1:] @ noise[:-1] / (noise @ noise), 0.0, 0.99))
    lasts = (1.0 + memory) / (1.0 - memory)  # so many cells hold one draw of it
    deviation = 1.4826 * float(np.median(np.abs(noise))) * np.sqrt(np.minimum(lasts / length, 1.0))
    near = (np.abs(levels) < REST * deviation) & (length > WIDEST)
    stays = edges[:-1][near[edges[:-1]]]
    nearer = int(np.count_nonzero(np.abs(levels[stays]) < 0.5 * REST * deviation[stays]))
    rests: NDArray[np.bool_] = near & (2 * nearer - stays.size > CROWD * np.sqrt(stays.size))
    return rests


def as_levels(signals: Signals) -> Array:
    """(n,) a torque that stays between its jumps as the mean of each stay; a cell that holds a jump is between both."""
    found = signals.torque.copy()
    for run in signals.runs():
        torque, level = signals.torque[run], found[run]
        edges, usual = leaps(torque)
        edges |= _slow_leaps(torque)
        still = np.concatenate([[False], ~edges, [False]])
        begins, ends = np.flatnonzero(still[1:] & ~still[:-1]), np.flatnonzero(still[:-1] & ~still[1:])
        means = [float(np.mean(torque[a:b])) for a, b in zip(begins, ends, strict=True)]
        for a, b, mean in zip(begins, ends, means, strict=True):
            level[a:b] = mean
        for a, b, before, after in zip(ends[:-1], begins[1:], means[:-1], means[1:], strict=True):
            if b - a <= WIDEST:
                inside = np.clip(torque[a:b], min(before, after), max(before, after))
                inside = np.where(np.abs(inside - before) < usual, before, inside)
                level[a:b] = np.where(np.abs(inside - after) < usual, after, inside)
    return found


def _slow_leaps(torque: Array) -> NDArray[np.bool_]:
    """(n,) cells about those in which the means of a few cells before and after differ the most, and unusually so.

    A jump that takes two samples, or is hardly larger than the noise of one, is none from cell to cell.
    """
    beside = uniform_filter1d(torque, FEW)
    change = np.zeros(torque.size)
    apart = FEW // 2 + 1
    change[apart:-apart] = np.abs(beside[2 * apart :] - beside[: -2 * apart])
    usual = LEAP * 1.4826 * float(np.median(change)) + COARSE * float(np.std(torque))
    highest = (change > usual) & (change == maximum_filter1d(change, 2 * FEW + 1))
    cells: NDArray[np.bool_] = maximum_filter1d(highest, 3)
    return cells


def shared(levels: Array) -> Array | None:
    """`levels` with the stays at one of a few levels at that; None where the command takes any.

    A stay holds as much noise as lasts with it; a level that the command comes back to, that of all its stays.
    """
    edges = np.flatnonzero(np.diff(levels, prepend=np.nan, append=np.nan) != 0.0)
    length = np.diff(edges)
    stays = length > WIDEST
    level, weight = levels[edges[:-1][stays]], length[stays].astype(np.float64)
    best: tuple[float, Array] = APART, np.zeros(0)
    for few in range(2, min(MOST_LEVELS, level.size // VISITS) + 1):
        centres = _centres(level, weight, few)
        own = np.argmin(np.abs(level[:, None] - centres), axis=1)
        scatter = float(np.sqrt(np.average((level - centres[own]) ** 2, weights=weight)))
        # of too few levels one would hold two, of too many two would lie beside each other
        best = min(best, (scatter / float(np.min(np.diff(centres))), centres[own]), key=lambda each: each[0])
    if not best[1].size:
        return None
    found = levels.copy()
    found[np.repeat(stays, length)] = np.repeat(best[1], length[stays])
    return found


def _centres(level: Array, weight: Array, few: int) -> Array:
    """(few,) about which the levels scatter least, rising: by dynamic programming over a count, then means."""
    cell = np.linspace(level.min(), level.max() + 1e-9, CELLS + 1)
    count, *moments = (np.histogram(level, cell, weights=weight * level**k)[0] for k in range(3))
    n, first, second = (np.concatenate([[0.0], np.cumsum(x)]) for x in (count, *moments))
    a, b = np.arange(CELLS)[:, None], np.arange(1, CELLS + 1)
    mass, moment = np.maximum(n[b] - n[a], 1e-9 * n[-1]), first[b] - first[a]
    cost = np.where(b > a, np.maximum(second[b] - second[a] - moment**2 / mass, 0.0), np.inf)
    best, cuts = cost[0], []
    for _ in range(few - 1):
        total_cost = best[:-1, None] + cost[1:]
        cuts.append(np.argmin(total_cost, axis=0) + 1)
        best = np.min(total_cost, axis=0)
    ends = [CELLS]
    for cut in reversed(cuts):
        ends.append(int(cut[ends[-1] - 1]))
    own = np.searchsorted(cell[np.array(ends[:0:-1])], level)
    total = np.bincount(own, weights=weight, minlength=few)
    centres: Array = np.bincount(own, weights=weight * level, minlength=few) / np.maximum(total, 1e-300)
    return np.unique(centres)
