"""A recording as the engine reads it: velocities, efforts, angles and channels by their columns' names, in SI units."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.numerics import Array, Stream, Streams, robust_deviation
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


def between(stream: Stream, first: float, last: float) -> Stream:
    """The part of a stream between two instants, with the value that is in force at the first one."""
    time, values = stream
    begin = max(int(np.searchsorted(time, first, side="right")) - 1, 0)
    end = int(np.searchsorted(time, last, side="right"))
    return time[begin:end], values[begin:end]


def together(streams: Streams) -> Streams:
    """The recording from when all its streams have begun until one of them ends."""
    first, last = max(float(t[0]) for t, _ in streams.values()), min(float(t[-1]) for t, _ in streams.values())
    return {name: between(stream, first, last) for name, stream in streams.items()}


def without_pauses(
    streams: Streams,
    names: Sequence[str],
    periods: float,  # of a stream that pass in a pause at least
    seconds: float = 1.0,  # likewise: a Doppler log sends once a second
) -> list[Streams]:
    """The stretches of a recording in which none of some streams pauses; all of it, as it is, where none does."""
    pauses = []
    for time in (streams[name][0] for name in names):
        long = np.flatnonzero(np.diff(time) > max(seconds, periods * float(np.median(np.diff(time)))))
        pauses += [(float(time[k]), float(time[k + 1])) for k in long]
    if not pauses:
        return [streams]
    found, begin = list[Streams](), max(float(streams[name][0][0]) for name in names)
    end = min(float(streams[name][0][-1]) for name in names)
    for stop, resume in [*sorted(pauses), (end, end)]:
        if min(stop, end) > begin:
            found.append({name: between(each, begin, min(stop, end)) for name, each in streams.items()})
        begin = max(begin, resume)
    return found
