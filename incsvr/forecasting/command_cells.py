"""Yaw rate and torque from one command to the next, as a controller sees them: nothing in a cell answers what happens
in it, so that errors of prediction over cells are sound in closed loop, too (U. Forssell, L. Ljung, Automatica 35,
1999)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from incsvr.numerics import Array
from incsvr.numerics.cell_means import integral_at
from incsvr.signals.samples import Indices

MIN_CELL_PERIODS = 0.8
"""Least length of a cell in periods of the gyro, between whose values nothing shows, and of the command, which a log
repeats while it is held: a jitter of stamps merges no two commands. Of quicker commands a cell holds several, and the
later ones answer what happens in it."""
MIN_CELL_S, MAX_MIN_CELL_S = 0.015, 0.3
"""Bounds on that length [s]: cells that are shorter cost time and tell no more, and a command that is held for longer
leaves many of them."""
MAX_CELL_S = 2.0
"""Length of a cell at most [s]; a longer pause of the torque, or of the yaw rate, is in none."""
SPIKE_SAMPLES = 3
"""Values of a quick gyro of which the middle one counts."""


@dataclass(frozen=True, slots=True)
class CommandCells:
    """n cells, in the order of their time.

    Attributes:
        end, length: (n,) [s].
        first, last: (n,) yaw rate at both ends [rad/s].
        torque: (n,) mean [N m].
    """

    end: Array
    length: Array
    first: Array
    last: Array
    torque: Array

    @staticmethod
    def of(
        rate: tuple[Array, Array], torque: tuple[Array, Array], after: float, until: float, held: bool
    ) -> CommandCells:
        """The cells between two times [s], of streams (stamps [s], values) that increase.

        Args:
            after: the end of the last cell before, or −∞.
            until: the last time at which a cell may end.
            held: whether the torque holds until its next value; else it runs on a line between two.
        """
        (stamps, values), (commanded, moments) = rate, torque
        known = stamps[stamps <= until]
        if known.size < 2 or commanded.size < 2:
            return CommandCells.none()
        period = float(np.median(np.diff(known)))
        slower = max(period, _held_for(commanded[commanded <= until], moments[commanded <= until]))
        shortest = min(max(MIN_CELL_PERIODS * slower, MIN_CELL_S), MAX_MIN_CELL_S)
        edges = _edges(commanded, after, min(until, float(stamps[-1])), shortest)
        edges = edges[edges >= stamps[0]]
        if edges.size < 2:
            return CommandCells.none()
        if period * SPIKE_SAMPLES <= min(float(np.median(np.diff(edges))), MAX_MIN_CELL_S):
            beside = np.median(np.lib.stride_tricks.sliding_window_view(values, SPIKE_SAMPLES), axis=1)
            values = np.concatenate((values[:1], beside, values[-1:]))
        at = np.interp(edges, stamps, values)
        pause = np.diff(stamps)[np.clip(np.searchsorted(stamps, edges) - 1, 0, stamps.size - 2)]
        length = np.diff(edges)
        means = np.diff(integral_at(commanded, moments, edges, held)) / length
        whole = (length <= MAX_CELL_S) & (np.maximum(pause[1:], pause[:-1]) <= MAX_CELL_S)
        cells = CommandCells(edges[1:], length, at[:-1], at[1:], means)
        return cells.take(whole)

    @staticmethod
    def none() -> CommandCells:
        nothing = np.empty(0)
        return CommandCells(nothing, nothing, nothing, nothing, nothing)

    def __len__(self) -> int:
        return self.end.size

    def take(self, index: Indices) -> CommandCells:
        """The cells at an index, such as a mask."""
        return CommandCells(
            self.end[index], self.length[index], self.first[index], self.last[index], self.torque[index]
        )

    def followed_by(self, later: CommandCells, since: float) -> CommandCells:
        """These and later ones, but for those that end before a time [s]."""
        columns = zip(self._columns(), later._columns(), strict=True)
        joined = CommandCells(*(np.concatenate(pair) for pair in columns))
        return joined.take(joined.end >= since)

    def _columns(self) -> tuple[Array, ...]:
        return self.end, self.length, self.first, self.last, self.torque


def _held_for(stamps: Array, commands: Array) -> float:
    """The time [s] for which a command is held: half of the time belongs to those that last longer; ∞ of one alone."""
    lasts = np.sort(np.diff(stamps[1:][np.diff(commands) != 0.0]))
    until = np.cumsum(lasts)
    return float(lasts[np.searchsorted(until, 0.5 * until[-1])]) if lasts.size else np.inf


def _edges(stamps: Array, after: float, until: float, shortest: float) -> Array:
    """Stamps at least `shortest` [s] apart, the first of them `after` itself where there is one."""
    found = [after] if np.isfinite(after) else []
    for stamp in stamps[(stamps > after) & (stamps <= until)].tolist():
        if not found or stamp - found[-1] >= shortest - 1e-6:
            found.append(stamp)
    return np.array(found)
