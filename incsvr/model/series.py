"""A recording as the engine reads it: velocities, efforts, angles and channels by their columns' names, in SI units."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.numerics import Array, Streams, robust_deviation
from incsvr.plant.axes import of_rate


def effort_of(rate: str) -> str:
    """The column of the effort that drives a velocity."""
    return of_rate(rate).effort


def every(series: Streams, count: int) -> Streams:
    """The recording with every `count`-th sample of every stream, as a coarser log records it."""
    return {name: (t[::count], v[::count]) for name, (t, v) in series.items()}


def period(runs: Sequence[Streams], name: str) -> float:
    """The usual time between two samples of a stream [s]."""
    return float(np.median(np.concatenate([np.diff(run[name][0]) for run in runs if name in run])))


def values(runs: Sequence[Streams], name: str) -> Array:
    """(n,) all samples of a stream."""
    return np.concatenate([run[name][1] for run in runs if name in run])


def duration(runs: Sequence[Streams], name: str) -> float:
    """The recordings' length together [s]."""
    return float(sum(run[name][0][-1] - run[name][0][0] for run in runs))


def noise(value: Array) -> float:
    """The sensor's white noise, from third differences, which a smooth motion hardly has (in the value's unit)."""
    third = np.diff(value, 3)
    usual = robust_deviation(third) / np.sqrt(20.0) if third.size else 0.0  # (1, 3, 3, 1): variance 20
    return float(max(usual, 1e-3 * np.std(value), 1e-12))
