"""Recordings as cells of the streams' own period: what is known at the beginning of each, and the rise of the rate."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from incsvr.effects import Signals
from incsvr.errors import BadInput
from incsvr.tracer.grid import pieces, time_scale
from incsvr.tracer.run import Run, sample_period, stream

Array = NDArray[np.float64]

MOST_CELLS = 60_000
"""Of all recordings together; beyond, a cell is several periods of the gyro: an hour at 20 Hz takes a minute else."""

SPIKE, ABOVE = 6.0, 12.0
"""Times what the neighbours differ, and times the usual bend, by which one sample stands out that is no measurement."""

EVEN = 0.05
"""Of a period that stamps may be off an even grid before they are no longer taken for its edges."""

LAGS = 3
"""Cells of the past from which the next command is predicted: a controller's and its filter's."""

RUNNING = (4.0, 20.0)
"""Cells of the running means of a command's surprise: a Kalman filter with that gyro would forget as slowly."""

ALIKE = (0.6, 1.6)
"""Period of the torque over that of the gyro between which the cells begin where commands are given: a command in the
middle of a cell would answer what happened in its first part, and nothing that answers is known at the beginning."""


@dataclass(frozen=True, slots=True)
class Grid:
    """All pieces of all runs, one after the other.

    Attributes:
        signals: of each cell the mean of the torque, held from command to command, and of the channels; rate and
            heading at its beginning.
        rise: (n,) r[k + 1] − r[k] [rad/s].
        shift: (n,) by how much the mean torque changes for a second by which its stamps are late [N m/s].
        surprise: (n,) what of each command does not follow from what the log holds before it [N m]: of a controller
            that sees another gyro than the log's, it tells what that gyro saw.
        command: (n,) the torque in force just before each cell's end, the newest that is known there [N m].
        torque_period: between two commands [s].
        run: (pieces,) which recording each piece is from.
    """

    signals: Signals
    rise: Array
    shift: Array
    surprise: Array
    command: Array
    torque_period: float
    run: NDArray[np.intp]

    @property
    def cell(self) -> float:
        """h [s]."""
        return self.signals.step

    @property
    def starts(self) -> NDArray[np.intp]:
        """(pieces + 1,) first cell of each piece, and the end."""
        return self.signals.start

    def pieces(self, slices: Sequence[slice]) -> Grid:
        """These pieces of the grid as recordings of their own."""
        index = np.concatenate([np.arange(piece.start, piece.stop) for piece in slices])
        moved = self.signals.pieces(slices)
        of = np.searchsorted(self.starts, [piece.start for piece in slices], side="right") - 1
        return Grid(
            moved,
            self.rise[index],
            self.shift[index],
            self.surprise[:, index],
            self.command[index],
            self.torque_period,
            self.run[of],
        )


def cells(runs: Sequence[Run], inertia: float, names: Sequence[str]) -> Grid:
    """The recordings as cells. Raises BadInput where yaw rate and torque never overlap."""
    period, torque_period = sample_period(runs, "yaw_rate"), sample_period(runs, "torque")
    count = sum(int(np.isfinite(run.yaw_rate).sum()) for run in runs)
    by_command = ALIKE[0] < torque_period / period < ALIKE[1]
    step = (torque_period if by_command else period) * max(1, -(-count // MOST_CELLS))
    parts: list[dict[str, Array]] = []
    starts, origin = [0], []
    for number, run in enumerate(runs):
        for piece in pieces(run):
            at, rate = stream(piece, piece.yaw_rate)
            when, torque = stream(piece, piece.torque)
            begin, end = max(at[0], when[0]), min(at[-1], when[-1])
            clock = when if by_command else at
            first = clock[np.searchsorted(clock, begin)] if begin <= clock[-1] else end
            edges = first + step * np.arange(max(int((end - first) / step + 1e-9) + 1, 0))
            if edges.size < 6:
                continue
            edges = _snapped(edges, clock, step)
            rate = _rate_at(edges, at, _without_spikes(rate), when, torque, inertia)
            part = {
                "time": edges[:-1],
                "rate": rate[:-1],
                "rise": np.diff(rate),
                "torque": _held_mean(when, torque, edges),
                "shift": -np.diff(_before(when, torque, edges)) / step,
                "command": _before(when, torque, edges)[1:],
            }
            for name in names:
                stamps, values = stream(piece, piece.channels[name])
                angle = np.unwrap(values) if name == "heading" else values
                part[name] = np.interp(edges[:-1], stamps, angle) if stamps.size else np.zeros(edges.size - 1)
            parts.append(part)
            origin.append(number)
            starts.append(starts[-1] + edges.size - 1)
    if not parts:
        raise BadInput("yaw_rate and torque never overlap in time: check the stamps of the two streams")
    joined = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    time, heading = joined.pop("time"), joined.pop("heading", None)
    rise, shift, command = joined.pop("rise"), joined.pop("shift"), joined.pop("command")
    start = np.array(starts, dtype=np.intp)
    rate, torque = joined.pop("rate"), joined.pop("torque")
    if heading is None:
        heading = np.concatenate([step * (np.cumsum(rate[a:b]) - rate[a:b]) for a, b in itertools.pairwise(start)])
    signals = Signals(
        step=step,
        start=start,
        time=time,
        rate=rate,
        torque=torque,
        channels=joined,
        heading=heading,
        known=True,
        inertia=inertia,
        scale=time_scale(runs),
        block=step,
        origin=(float(time.min()), float(time.max()) + step),
    )
    surprise = _surprise(signals)
    return Grid(signals, rise, shift, surprise, command, torque_period, np.array(origin, dtype=np.intp))


def _surprise(s: Signals) -> Array:
    """(3, n) the torque less its linear prediction from the torques before it, and from rate and heading up to now;
    what
    is
    larger than usual is a turn that was asked for, and is cut.
    """
    history = [np.roll(s.torque, k) for k in range(1, LAGS + 1)]
    history += [np.roll(values, k) for values in (s.rate, s.heading) for k in range(LAGS)]
    design = np.stack([*history, np.ones(len(s))], axis=1)
    usable = np.ones(len(s), dtype=bool)
    for k in range(LAGS):
        usable[np.minimum(s.start[:-1] + k, len(s) - 1)] = False
    left = np.zeros(len(s))
    weight = usable.astype(np.float64)
    for _ in range(3):
        root = np.sqrt(weight)[:, None]
        left = s.torque - design @ np.linalg.lstsq(design * root, s.torque * root[:, 0])[0]
        usual = 1.4826 * float(np.median(np.abs(left[usable])))
        weight = usable / (1.0 + (left / max(3.0 * usual, 1e-12)) ** 2)
    new = np.where(usable, np.clip(left, -4.0 * usual, 4.0 * usual), 0.0)
    return np.stack([new, *(lfilter([1.0 / length], [1.0, 1.0 / length - 1.0], new) for length in RUNNING)])


def _without_spikes(rate: Array) -> Array:
    """The rate with single samples replaced that stand out from neighbours which agree: the top of a fast turn
    stays."""
    if rate.size < 5:
        return rate
    middle = 0.5 * (rate[1:-3] + rate[3:-1])
    bend = np.abs(rate[2:-2] - middle)
    steps = [rate[1:-3] - rate[:-4], rate[4:] - rate[3:-1], rate[3:-1] - rate[1:-3]]
    spike = (bend > SPIKE * np.max(np.abs(steps), axis=0)) & (bend > ABOVE * float(np.median(bend)))
    out = rate.copy()
    out[2:-2][spike] = middle[spike]
    return out


def _snapped(edges: Array, clock: Array, step: float) -> Array:
    """The edges, or the stamps themselves where the clock is as even as they are."""
    nearest = clock[np.clip(np.searchsorted(clock, edges - 0.5 * step), 0, clock.size - 1)]
    return nearest if np.max(np.abs(nearest - edges)) < EVEN * step else edges


def _rate_at(edges: Array, at: Array, rate: Array, when: Array, torque: Array, inertia: float) -> Array:
    """The rate at the edges. Between two of its samples it has a corner wherever the command jumps; what the torque
    leaves of it, r − ∫τ/I₀ dt, has none and is interpolated.
    """
    turned = _integral(when, torque, at) / inertia
    return np.asarray(np.interp(edges, at, rate - turned) + _integral(when, torque, edges) / inertia)


def _before(at: Array, values: Array, when: Array) -> Array:
    """The command in force just before each instant: the one of that instant may already answer the rate's next
    rise."""
    return np.asarray(values[np.clip(np.searchsorted(at, when, side="left") - 1, 0, at.size - 1)])


def _integral(at: Array, values: Array, until: Array) -> Array:
    """Of the held command from its first stamp to each instant."""
    total = np.concatenate([[0.0], np.cumsum(values[:-1] * np.diff(at))])
    index = np.clip(np.searchsorted(at, until, side="right") - 1, 0, at.size - 1)
    return np.asarray(total[index] + values[index] * (until - at[index]))


def _held_mean(at: Array, values: Array, edges: Array) -> Array:
    """(n − 1,) mean of the held command between neighbouring edges (n,)."""
    return np.asarray(np.diff(_integral(at, values, edges)) / np.diff(edges))
