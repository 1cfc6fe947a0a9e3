"""Values that have nothing to do with their neighbours: a bit that flipped, a glitch on a wire.

A linear filter makes of one such value a sample that is wrong by any amount, and spoils all around it: they are left
out before it. What a vehicle or a command does lasts for two samples at least, and is no spike.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array

SPIKE_STEPS = 6.0
"""Typical steps from the median of itself and its neighbours beyond which a value is a spike: of normal noise one value
in two thousand is, whose loss nobody notices."""
LEVEL_VALUES = 4.0
"""Values of which no more than one differs from the one before in a stream that stands still or comes in levels."""
MIN_WINDOW_VALUES = 12
"""Values in a window from which on its neighbours say what a value should be."""


def distances(value: Array) -> Array:
    """(n,) how far each value is from the median of the three around it; nothing for the first and the last."""
    away = np.zeros(value.size)
    if value.size > 2:
        before, here, after = value[:-2], value[1:-1], value[2:]
        median = np.maximum(np.minimum(before, after), np.minimum(np.maximum(before, after), here))
        away[1:-1] = np.abs(here - median)
    return away


def spikes(
    away: Array, step: Array, starts: NDArray[np.intp], counts: NDArray[np.intp]
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Selects values that are spikes in some windows, and values that move alone in constant windows.

    The typical step is the window's own: the geometric mean of those that are not zero, which a fifth of spikes hardly
    moves. Where the stream stands still or comes in levels it is the smallest.

    Args:
        away: (n,) the distances of all windows, one window after the other; those at a window's ends are zero.
        step: (n,) from one value to the next; that of a window's last value is zero.
        starts, counts: (m,) where each window begins, and how many values it has, at least one.
    """
    moves = step > 0.0
    many = np.add.reduceat(moves.astype(np.float64), starts)
    logarithm = np.log(np.where(moves, step, 1.0))
    usual = np.exp(np.add.reduceat(logarithm, starts) / np.maximum(many, 1.0))
    smallest = np.minimum.reduceat(np.where(moves, step, np.inf), starts)
    still = (LEVEL_VALUES * many < counts) & (counts >= MIN_WINDOW_VALUES)
    typical = np.where(counts < MIN_WINDOW_VALUES, np.inf, np.where(still, smallest, usual))
    found: NDArray[np.bool_] = away > SPIKE_STEPS * np.repeat(typical, counts)
    return found, (away > 0.0) & np.repeat(still, counts)


class SpikeCount:
    """The number of spikes of each stream: windows overlap, and each value counts once.

    Attributes:
        counts: name → how many.
    """

    def __init__(self) -> None:
        self.counts: Counter[str] = Counter()
        self._newest: dict[str, float] = {}

    def saw(self, left_out: Mapping[str, Array]) -> None:
        """Spikes of some windows, name → stamps [s], increasing; the windows follow those of the last call."""
        for name, stamps in left_out.items():
            fresh = stamps[stamps > self._newest.get(name, -np.inf)]
            if fresh.size:
                self.counts[name] += fresh.size
                self._newest[name] = float(fresh[-1])

    def clock_began_anew(self) -> None:
        """Stamps that follow may be lower than those before."""
        self._newest.clear()
