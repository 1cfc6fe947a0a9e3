"""Recordings cut into windows that are simulated side by side, and each sensor's samples among their steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np

from incsvr.model.efforts import Stage, lagged, means
from incsvr.model.factors import Indices
from incsvr.model.rows import Row
from incsvr.model.series import effort_of, noise, values
from incsvr.model.structure import Structure
from incsvr.numerics import Array, Stream, Streams

ANGLES = {"roll": "roll_rate", "pitch": "pitch_rate", "heading": "yaw_rate"}
"""Angles that follow from a velocity."""


@dataclass(frozen=True, slots=True)
class Grid:
    """The steps of one recording.

    Attributes:
        origin: stamp of its first edge [s].
        steps: how many.
        first: place of its first edge among those of all recordings.
    """

    origin: float
    steps: int
    first: int


@dataclass(frozen=True, slots=True)
class Samples:
    """The samples in one step of all windows.

    Attributes:
        which: their places among all samples.
        axis, window: of each.
        flat: place of the velocity in an array (axes, windows).
        shares: (3, samples) in a sample's value of the velocities at the step's beginning and end, and of the slope at
            its beginning [s]: a parabola.
        inside: whether any is before the step's end.
    """

    which: Indices
    axis: Indices
    window: Indices
    flat: Indices
    inside: bool
    shares: Array


@dataclass(frozen=True)
class Windows:
    """Windows of recordings, each of at most `steps` steps; with an infinite horizon each recording is one window.

    Attributes:
        runs: the recordings.
        axes: velocities that are predicted.
        step: of the simulation [s].
        grids: of each recording.
        first: (windows,) place of each window's first edge.
        count: (windows,) its steps.
        run: (windows,) its recording.
        axis, window, cell, part, measured: (samples,) each sample's axis, window, step, place within the step from 0 to
            1, and value [m/s], [rad/s], sorted by window.
        starts: (axes, windows) measured velocities at each window's first edge.
        noise: (axes,) deviation of the sensors' white noise [m/s], [rad/s].
        channel: each channel on all edges.
        velocity: each measured velocity on all edges.
    """

    runs: Sequence[Streams]
    axes: tuple[str, ...]
    step: float
    grids: tuple[Grid, ...]
    first: Indices
    count: Indices
    run: Indices
    axis: Indices
    window: Indices
    cell: Indices
    part: Array
    measured: Array
    starts: Array
    noise: Array
    channel: dict[str, Array]
    velocity: dict[str, Array]
    _cache: dict[tuple[object, ...], Array] = field(default_factory=dict)

    @cached_property
    def steps(self) -> int:
        """Steps of the longest window."""
        return int(self.count.max())

    @cached_property
    def samples(self) -> list[slice]:
        """The samples of each window."""
        bounds = np.searchsorted(self.window, np.arange(self.first.size + 1)).tolist()
        return [slice(a, b) for a, b in pairwise(bounds)]

    @cached_property
    def at(self) -> Indices:
        """(steps + 1, windows) place of each window's edges; a short window repeats its last."""
        return np.asarray(np.minimum(self.first + np.arange(self.steps + 1)[:, None], self.first + self.count))

    @cached_property
    def by_step(self) -> list[Samples | None]:
        """The samples in each step, None where there are none."""
        order = np.argsort(self.cell, kind="stable")
        bounds = np.searchsorted(self.cell[order], np.arange(self.steps + 1))
        return [self._inside(order[a:b]) if b > a else None for a, b in pairwise(bounds)]

    def _inside(self, which: Indices) -> Samples:
        axis, window, f = self.axis[which], self.window[which], self.part[which]
        f = np.where(f > 0.999, 1.0, f)
        shares = np.stack([1.0 - f * f, f * f, self.step * (f - f * f)])
        return Samples(which, axis, window, axis * self.first.size + window, bool(np.any(f < 1.0)), shares)

    def edges(self, grid: Grid) -> Array:
        """(steps + 1,) edges of a recording [s]."""
        return np.asarray(grid.origin + self.step * np.arange(grid.steps + 1))

    def effort(self, axis: str, way: str, stage: Stage) -> Array:
        """(steps, windows) the mean effort of an axis in each step, after its stages."""
        key = ("effort", axis, way, stage)
        if key not in self._cache:
            name, parts = effort_of(axis), list[Array]()
            top = self.largest(name)
            for run, grid in zip(self.runs, self.grids, strict=True):
                mean = means(run[name], self.edges(grid), way, stage, top)
                parts += [mean, mean[-1:]]
            self._keep(key, np.concatenate(parts)[self.at[:-1]])
        return self._cache[key]

    def memory(self, row: Row, constant: float) -> Array:
        """(windows,) a row's memory at each window's first edge, from what was measured before it."""
        key = ("memory", row.key, constant)
        if key not in self._cache:
            followed = {**self.velocity, **self.channel}[row.follows]
            parts = [
                lagged(followed[grid.first : grid.first + grid.steps + 1], self.step / constant) for grid in self.grids
            ]
            self._keep(key, np.concatenate(parts)[self.first])
        return self._cache[key]

    def largest(self, name: str) -> float:
        """The quantile of 99.9 % of the sizes of an effort, at which thrust curves agree."""
        key = ("largest", name)
        if key not in self._cache:
            self._cache[key] = np.array(max(float(np.quantile(np.abs(values(self.runs, name)), 0.999)), 1e-12))
        return float(self._cache[key])

    def _keep(self, key: tuple[object, ...], value: Array) -> None:
        if len(self._cache) > 32:  # candidates ask for the base's few again and again, and each for its own
            self._cache.clear()
        self._cache[key] = value


def cut(runs: Sequence[Streams], structure: Structure, step: float, horizon: float) -> Windows:
    """Cuts recordings into windows of a horizon [s]; with an infinite one each recording is one window."""
    grids, windows, samples, first_edge = list[Grid](), list[tuple[int, int, int]](), list[Array](), 0
    for which, run in enumerate(runs):
        used = [run[name] for name in (*structure.axes, *structure.channels)]
        used += [run[effort_of(axis)] for axis in structure.driven]
        begin, end = max(t[0] for t, _ in used), min(t[-1] for t, _ in used)
        # Steps begin with its samples: no sample is predicted by efforts that answer it.
        own = run[structure.axes[0]][0]
        begin = float(own[min(np.searchsorted(own, begin - 1e-9), own.size - 1)])
        steps = int(np.floor((end - begin) / step + 1e-6))
        length = int(max(1, min(steps, np.round(min(horizon, 1e9) / step))))
        place = np.full(steps // length + 2, -1)
        for k in range(0, max(steps - (length - 1 if length < steps else 0), 1), length):
            place[k // length] = len(windows)
            windows.append((first_edge + k, min(length, steps - k), which))
        for i, axis in enumerate(structure.axes):
            samples.append(_samples(run[axis], begin, step, steps, length, place, i))
        grids.append(Grid(begin, steps, first_edge))
        first_edge += steps + 1
    rows = np.concatenate(samples)
    rows = rows[np.argsort(rows[:, 1], kind="stable")]
    first, count, run_of = np.array(windows).T
    return _windows(runs, structure, step, grids, (first, count, run_of), rows)


def beginning_at(run: Streams, structure: Structure, step: float, first: Indices, most: int) -> Windows:
    """Windows of one recording for free runs alone: they begin at given edges, may overlap, and have no samples.

    Args:
        run: with values of the first axis on all edges, `step` [s] apart.
        first: (windows,) places of their first edges.
        most: steps of a window at most; the recording ends those that begin late.
    """
    time = run[structure.axes[0]][0]
    grid = Grid(float(time[0]), time.size - 1, 0)
    count = np.minimum(most, grid.steps - first)
    return _windows([run], structure, step, [grid], (first, count, np.zeros_like(first)), np.zeros((0, 5)))


def _windows(
    runs: Sequence[Streams],
    structure: Structure,
    step: float,
    grids: Sequence[Grid],
    places: tuple[Indices, Indices, Indices],
    rows: Array,
) -> Windows:
    """The windows with these first edges, counts of steps and recordings, and these samples (n, 5)."""
    on_edges = {
        name: np.concatenate([
            _on(run[name], np.asarray(grid.origin + step * np.arange(grid.steps + 1)), name in ANGLES)
            for run, grid in zip(runs, grids, strict=True)
        ])
        for name in dict.fromkeys((*structure.axes, *structure.channels))
    }  # fmt: skip
    usual = [np.median([noise(run[axis][1]) for run in runs]) for axis in structure.axes]
    return Windows(
        runs, structure.axes, step, tuple(grids), *places,
        rows[:, 0].astype(np.intp), rows[:, 1].astype(np.intp), rows[:, 2].astype(np.intp), rows[:, 3], rows[:, 4],
        np.stack([on_edges[axis][places[0]] for axis in structure.axes]),
        np.array(usual),
        {name: on_edges[name] for name in structure.channels}, {name: on_edges[name] for name in structure.axes},
    )  # fmt: skip


def _samples(stream: Stream, begin: float, step: float, steps: int, length: int, place: Indices, axis: int) -> Array:
    """(n, 5) of a sensor's samples: axis, window, step of the window, place within the step, value."""
    t, v = stream
    at = (t - begin) / step
    if np.median(np.diff(at)) < 0.75:  # several samples a step: their mean at their mean stamp
        bin_ = np.round(at).astype(int)
        bin_ -= bin_[0]
        number = np.bincount(bin_)
        filled = number > 0
        at, v = (np.bincount(bin_, x)[filled] / number[filled] for x in (at, v))
    cell = np.floor(at - 1e-6).astype(int)  # a sample on a window's first edge closes the window before it
    window = place[np.clip(cell // length, 0, place.size - 1)]
    inside = (cell >= 0) & (window >= 0) & (at <= steps + 1e-6)
    columns: tuple[Array, ...] = (np.full(at.size, axis), window, cell % length, at - cell, v)
    return np.asarray(np.stack(columns, axis=1)[inside])


def _on(stream: Stream, edges: Array, is_angle: bool) -> Array:
    """A stream on the edges, on lines between its samples; an angle without its jumps of a turn."""
    t, v = stream
    return np.asarray(np.interp(edges, t, np.unwrap(v) if is_angle else v))
