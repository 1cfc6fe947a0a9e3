"""The recorded motion of a whole vehicle on one grid: velocities, efforts and angles of several runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from incsvr.errors import BadInput
from incsvr.numerics import Array, Stream, Streams, cell_means
from incsvr.plant.axes import AXES, EFFORTS, VELOCITIES

ANGLES = ("roll", "pitch", "heading")
"""φ, θ and ψ [rad] as recordings call them."""
MAX_GAP_S = 1.0
"""Longest pause of a stream that a line bridges [s]; a run ends at a longer one. A Doppler log sends once a second."""
MIN_RUN_CELLS = 20
"""Shortest stretch that is kept, in cells: a shorter one holds hardly a window."""
HELD_SHARE = 0.3
"""Share of values that repeat the one before, from which an effort is a command that holds until the next message."""
CELLS_A_SCALE = 12.0
"""Cells in the shortest time over which a velocity stays correlated: the effort is a line in each."""
PARTS_A_CELL = 8
"""Parts of a cell from whose means the line of its effort is taken."""


@dataclass(frozen=True, slots=True)
class WholeMotion:
    """Several runs on a grid of equal cells, one after the other.

    Attributes:
        step: length of a cell [s].
        velocity: (n, 6) ν at the beginning of each cell [m/s], [rad/s]; zero where an axis is not recorded.
        effort: (n, 6) mean τ of each cell [N], [N m]; zero where nothing is recorded.
        effort_rise: (n, 6) by how much the line that has τ's mean and first moment rises over each cell: a step within
            a cell acts longer where it comes early, and without this inertias come out too small.
        angle: (n, 3) roll, pitch and heading at the beginning of each cell [rad]; zero where not recorded.
        start: (runs + 1,) first cell of each run, and n.
        recorded: names of the velocities, efforts and angles that every run has.
    """

    step: float
    velocity: Array
    effort: Array
    effort_rise: Array
    angle: Array
    start: NDArray[np.intp]
    recorded: frozenset[str]

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the axes whose velocity is recorded, in the order of ν."""
        return tuple(axis.name for axis in AXES.values() if axis.rate in self.recorded)

    @property
    def runs(self) -> list[slice]:
        """The cells of each run."""
        return [slice(a, b) for a, b in zip(self.start[:-1].tolist(), self.start[1:].tolist(), strict=True)]

    @property
    def seconds(self) -> float:
        """Length of all runs [s]."""
        return float(self.start[-1]) * self.step

    def windows(self, cells: int) -> NDArray[np.intp]:
        """First cells of the stretches of `cells` cells that fit into the runs, one after the other."""
        return np.concatenate([np.arange(run.start, run.stop - cells, cells) for run in self.runs]).astype(np.intp)

    def between(self, first: int, last: int) -> WholeMotion:
        """The cells from `first` to before `last`; a run that is cut ends or begins there."""
        inner = self.start[(self.start > first) & (self.start < last)]
        start = np.concatenate(([first], inner, [last])) - first
        cells = slice(first, last)
        velocity, effort, rise, angle = (getattr(self, name)[cells] for name in COLUMNS)
        return WholeMotion(self.step, velocity, effort, rise, angle, start.astype(np.intp), self.recorded)


COLUMNS = ("velocity", "effort", "effort_rise", "angle")
"""The fields of a motion that have a row for each cell, in their order."""


def on_grid(runs: Sequence[Streams], step: float | None = None) -> WholeMotion:
    """The runs of one vehicle on one grid.

    Args:
        runs: the streams of each run: velocities [m/s], [rad/s], efforts [N], [N m] and angles [rad] by the names of
            recordings; others are ignored.
        step: length of a cell [s]; None fits it to the streams and to how fast the velocities change.

    Raises:
        BadInput: no velocity is in every run, or no stretch is long enough.
    """
    names = (*VELOCITIES, *EFFORTS, *ANGLES)
    recorded = frozenset(name for name in names if all(name in run and run[name][0].size > 1 for run in runs))
    if not recorded & set(VELOCITIES):
        raise BadInput(
            "no velocity of the vehicle is in every recording; name them: --column surge=NAME --column yaw_rate=NAME"
        )
    stretches = [part for run in runs for part in _without_gaps({name: run[name] for name in recorded})]
    step = _fitting_step(stretches, recorded) if step is None else step
    parts = [part for part in (_cells(stretch, step) for stretch in stretches) if part is not None]
    if not parts:
        raise BadInput(
            "no stretch without gaps is long enough; give longer recordings, in which all velocities and efforts come "
            "together"
        )
    velocity, effort, rise, angle = (np.concatenate(column) for column in zip(*parts, strict=True))
    start = np.concatenate(([0], np.cumsum([part[0].shape[0] for part in parts]))).astype(np.intp)
    return WholeMotion(step, velocity, effort, rise, angle, start, recorded)


def joined(motions: Sequence[WholeMotion]) -> WholeMotion:
    """Motions on one grid, one after the other."""
    velocity, effort, rise, angle = (np.concatenate([getattr(each, name) for each in motions]) for name in COLUMNS)
    lengths = [np.diff(each.start) for each in motions]
    start = np.concatenate(([0], np.cumsum(np.concatenate(lengths)))).astype(np.intp)
    recorded = frozenset.intersection(*(each.recorded for each in motions))
    return WholeMotion(motions[0].step, velocity, effort, rise, angle, start, recorded)


def period(stream: Stream) -> float:
    """The usual time between two values of a stream [s]."""
    return float(np.median(np.diff(stream[0])))


def is_held(values: Array) -> bool:
    """Whether values are those of a command, which repeats itself while it holds."""
    moved = values[values != 0.0]
    return moved.size > 1 and float(np.mean(np.diff(moved) == 0.0)) >= HELD_SHARE


def _without_gaps(streams: Mapping[str, Stream]) -> list[dict[str, Stream]]:
    """The stretches in which every stream comes without a long pause."""
    first = max(float(time[0]) for time, _ in streams.values())
    last = min(float(time[-1]) for time, _ in streams.values())
    pauses = []
    for time, _ in streams.values():
        long = np.flatnonzero(np.diff(time) > max(MAX_GAP_S, 5.0 * float(np.median(np.diff(time)))))
        pauses += [(float(time[k]), float(time[k + 1])) for k in long]
    found, begin = [], first
    for stop, resume in [*sorted(pauses), (last, last)]:
        if min(stop, last) > begin:
            found.append((begin, min(stop, last)))
        begin = max(begin, resume)
    return [{name: _between(stream, *span) for name, stream in streams.items()} for span in found]


def _between(stream: Stream, first: float, last: float) -> Stream:
    """The part of a stream between two instants, with the value that holds at the first one."""
    time, values = stream
    begin = max(int(np.searchsorted(time, first, side="right")) - 1, 0)
    end = int(np.searchsorted(time, last, side="right"))
    return time[begin:end], values[begin:end]


def _fitting_step(stretches: Sequence[Streams], recorded: frozenset[str]) -> float:
    """The longest cell that the streams' periods and the quickest velocity allow [s]."""
    velocities = [name for name in VELOCITIES if name in recorded]
    slowest = max(float(np.median([period(part[name]) for part in stretches])) for name in velocities)
    longest = max(stretches, key=lambda part: float(part[velocities[0]][0][-1] - part[velocities[0]][0][0]))
    scale = min(_correlation_time(longest[name]) for name in velocities)
    return max(slowest, scale / CELLS_A_SCALE)


def _correlation_time(stream: Stream) -> float:
    """The time over which a velocity stays correlated, until its autocorrelation falls to 1/e [s]."""
    time, values = stream
    grid = np.linspace(time[0], time[-1], min(time.size, 20_000))
    centred = np.interp(grid, time, values) - np.mean(values)
    spectrum = np.abs(np.fft.rfft(centred, 2 * grid.size)) ** 2
    correlation = np.fft.irfft(spectrum)[: grid.size]
    below = np.flatnonzero(correlation < correlation[0] / np.e)
    return float(grid[below[0]] - grid[0]) if below.size else float(grid[-1] - grid[0])


def _cells(streams: Streams, step: float) -> tuple[Array, Array, Array, Array] | None:
    """Velocities, efforts, their rises and angles of one stretch; None where it is too short."""
    first = max(float(time[0]) for time, _ in streams.values())
    last = min(float(time[-1]) for time, _ in streams.values())
    count = int((last - first) / step + 1e-9)
    if count < MIN_RUN_CELLS:
        return None
    edges = np.asarray(first + step * np.arange(count + 1), dtype=np.float64)
    velocity, effort, rise, angle = (
        np.zeros((count, 6)),
        np.zeros((count, 6)),
        np.zeros((count, 6)),
        np.zeros((count, 3)),
    )
    parts = np.asarray(first + step / PARTS_A_CELL * np.arange(PARTS_A_CELL * count + 1), dtype=np.float64)
    middle = (np.arange(PARTS_A_CELL) + 0.5) / PARTS_A_CELL - 0.5
    for k, name in enumerate(VELOCITIES):
        if name in streams:
            # As it was there: a mean over a cell would show a step of the effort before it came, and so less inertia.
            velocity[:, k] = np.interp(edges[:-1], *streams[name])
    for k, name in enumerate(EFFORTS):
        if name in streams:
            time, values = streams[name]
            means = cell_means(time, values, parts, is_held(values)).reshape(count, PARTS_A_CELL)
            effort[:, k] = means.mean(axis=1)
            rise[:, k] = means @ middle / np.sum(middle**2)
    for k, name in enumerate(ANGLES):
        if name in streams:
            time, values = streams[name]
            angle[:, k] = np.interp(edges[:-1], time, np.unwrap(values))
    return velocity, effort, rise, angle
