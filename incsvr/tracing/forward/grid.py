"""Recordings as cells: what is known at the beginning of each, and the rise of the rate in it.

A cell is the time between two commands, so that nothing in a cell answers what happens in it.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from incsvr.effects import Signals
from incsvr.errors import BadInput
from incsvr.tracing.forward.interpolation import (
    before,
    mean_between,
    rate_at,
    snapped,
)
from incsvr.tracing.forward.torque import surprise
from incsvr.tracing.run import Run, sample_period, stream
from incsvr.tracing.weak.grid import pieces, time_scale

Array = NDArray[np.float64]

MOST_CELLS = 60_000
"""Of all recordings together; beyond, a cell is several periods of the gyro: an hour at 20 Hz takes a minute else."""

ALIKE = (0.6, 1.6)
"""Period of the torque over that of the gyro between which the cells begin where commands are given: a command in the
middle of a cell would answer what happened in its first part, and nothing that answers is known at the beginning."""


@dataclass(frozen=True, slots=True)
class Grid:
    """All pieces of all runs, one after the other.

    Attributes:
        signals: of each cell the mean of the torque and the rate at its beginning; heading and channels at its
            beginning, of a block in its middle.
        rise: (n,) `r[k + 1] − r[k]` in a cell of length `cell` [rad/s].
        shift: (n,) by how much the mean torque changes for a second by which its stamps are late [N m/s].
        surprise: (m, n) what of each command does not follow from what the log holds before it [N m]: of a controller
            that sees another gyro than the log's, it tells what that gyro saw. Empty for blocks.
        command: (n,) the torque in force just before each cell's end, the newest that is known there [N m].
        torque_period: between two torques [s].
        resolution: the longer period of the two streams [s].
        run: (pieces,) which recording each piece is from.
    """

    signals: Signals
    rise: Array
    shift: Array
    surprise: Array
    command: Array
    torque_period: float
    resolution: float
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
        of = np.searchsorted(self.starts, [piece.start for piece in slices], side="right") - 1
        return replace(
            self,
            signals=self.signals.pieces(slices),
            rise=self.rise[index],
            shift=self.shift[index],
            surprise=self.surprise[:, index],
            command=self.command[index],
            run=self.run[of],
        )


def cells(runs: Sequence[Run], inertia: float, names: Sequence[str]) -> Grid:
    """The recordings as cells of the streams' own period, the torque a command that holds until the next.

    Raises:
        BadInput: where yaw rate and torque never overlap.
    """
    period, torque_period = sample_period(runs, "yaw_rate"), sample_period(runs, "torque")
    count = sum(int(np.isfinite(run.yaw_rate).sum()) for run in runs)
    by_command = ALIKE[0] < torque_period / period < ALIKE[1]
    step = (torque_period if by_command else period) * max(1, -(-count // MOST_CELLS))
    grid = _cut(runs, inertia, names, step, by_command=by_command, blocks=False)
    return replace(grid, surprise=surprise(grid.signals))


def in_blocks(runs: Sequence[Run], inertia: float, names: Sequence[str], length: float) -> Grid:
    """The recordings as blocks of this length [s], the torque a command.

    Raises:
        BadInput: where yaw rate and torque never overlap.
    """
    return _cut(runs, inertia, names, length, by_command=False, blocks=True)


def _cut(
    runs: Sequence[Run],
    inertia: float,
    names: Sequence[str],
    step: float,
    *,
    by_command: bool,
    blocks: bool,
) -> Grid:
    """The recordings in cells of one length; of `blocks` channels and heading are those of the middle."""
    parts: list[dict[str, Array]] = []
    channels: dict[str, list[Array]] = {name: [] for name in names}
    starts, origin = [0], []
    late = 0.5 * step if blocks else 0.0
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
            edges = snapped(edges, clock, step)
            rate = rate_at(edges, at, rate, when, torque, inertia)
            newest = before(when, torque, edges)
            part = {
                "time": edges[:-1],
                "rate": rate[:-1],
                "rise": np.diff(rate) * (step / np.diff(edges)),
                "torque": mean_between(when, torque, edges),
                "shift": -np.diff(newest) / step,
                "command": newest[1:],
            }
            for name in names:
                stamps, values = stream(piece, piece.channels[name])
                angle = np.unwrap(values) if name == "heading" else values
                found = np.interp(edges[:-1] + late, stamps, angle) if stamps.size else np.zeros(edges.size - 1)
                channels[name].append(found)
            parts.append(part)
            origin.append(number)
            starts.append(starts[-1] + edges.size - 1)
    if not parts:
        raise BadInput("yaw_rate and torque never overlap in time: check the stamps of the two streams")
    joined = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    others = {name: np.concatenate(values) for name, values in channels.items()}
    time, heading = joined.pop("time"), others.pop("heading", None)
    rise, shift, command = joined.pop("rise"), joined.pop("shift"), joined.pop("command")
    start = np.array(starts, dtype=np.intp)
    rate, torque = joined.pop("rate"), joined.pop("torque")
    if heading is None:
        angles = [step * (np.cumsum(rate[a:b]) - rate[a:b]) for a, b in itertools.pairwise(start)]
        heading = np.concatenate(angles) + late * rate
    signals = Signals(
        step=step,
        start=start,
        time=time,
        rate=rate,
        torque=torque,
        channels=others,
        rate_name=runs[0].rate_name,
        heading=heading,
        known=True,
        inertia=inertia,
        scale=time_scale(runs),
        block=step,
        origin=(float(time.min()), float(time.max()) + step),
    )
    torque_period = sample_period(runs, "torque")
    return Grid(
        signals=signals,
        rise=rise,
        shift=shift,
        surprise=np.zeros((0, len(signals))),
        command=command,
        torque_period=torque_period,
        resolution=max(torque_period, sample_period(runs, "yaw_rate")),
        run=np.array(origin, dtype=np.intp),
    )
