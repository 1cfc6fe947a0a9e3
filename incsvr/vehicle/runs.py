"""The recordings of a vehicle as the engine takes them: what all of them have, without long pauses."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array, Stream, Streams
from incsvr.plant.axes import AXES, EFFORTS, VELOCITIES

ANGLES = ("roll", "pitch", "heading")
"""φ, θ and ψ [rad] as recordings call them."""
MAX_GAP_S = 1.0
"""Longest pause of a stream that a line bridges [s]; a run ends at a longer one. A Doppler log sends once a second."""
MIN_SAMPLES = 20
"""Samples of the slowest velocity in the shortest stretch that is fitted: a shorter one contains hardly a window."""
HELD_SHARE = 0.3
"""Share of values that repeat the one before, from which an effort is a command that is constant until the next one."""


def prepared(runs: Sequence[Streams]) -> list[Streams]:
    """The stretches without pauses, each with the velocities, efforts and angles that every run has.

    A velocity that never changes is left out: a column of zeros was not measured.

    Raises:
        BadInput: no velocity is in every run, or no stretch is long enough.
    """
    names = (*VELOCITIES, *EFFORTS, *ANGLES)
    recorded = [name for name in names if all(name in run and run[name][0].size > 1 for run in runs)]
    constant = [name for name in VELOCITIES if name in recorded and not any(np.ptp(run[name][1]) for run in runs)]
    recorded = [name for name in recorded if name not in constant]
    velocities = [name for name in recorded if name in VELOCITIES]
    if not velocities:
        raise BadInput(
            "no velocity that changes is in every recording; name them: --column surge=NAME --column yaw_rate=NAME"
        )
    found = [part for run in runs for part in _without_gaps({name: run[name] for name in recorded})]
    found = [part for part in found if min(part[name][0].size for name in velocities) > MIN_SAMPLES]
    if not found:
        raise BadInput(
            "no stretch without gaps is long enough; give longer recordings, in which all velocities and efforts come "
            "together"
        )
    return found


def axes_of(runs: Sequence[Streams]) -> tuple[str, ...]:
    """Names of the axes whose velocity every run has, in the order of ν."""
    return tuple(axis.name for axis in AXES.values() if all(axis.rate in run for run in runs))


def largest(runs: Sequence[Streams], names: Sequence[str]) -> Array:
    """(n,) the largest size of each stream; 0 of one that is not there."""
    found = [[np.abs(run[name][1]).max() for run in runs if name in run] for name in names]
    return np.array([max(each, default=0.0) for each in found])


def is_held(values: Array) -> bool:
    """Whether values are those of a command, which repeats itself until it changes."""
    moved = values[values != 0.0]
    return moved.size > 1 and float(np.mean(np.diff(moved) == 0.0)) >= HELD_SHARE


def between(stream: Stream, first: float, last: float) -> Stream:
    """The part of a stream between two instants, with the value that is in force at the first one."""
    time, values = stream
    begin = max(int(np.searchsorted(time, first, side="right")) - 1, 0)
    end = int(np.searchsorted(time, last, side="right"))
    return time[begin:end], values[begin:end]


def _without_gaps(streams: Streams) -> list[Streams]:
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
            parts = {name: between(stream, begin, min(stop, last)) for name, stream in streams.items()}
            found.append(parts)
        begin = max(begin, resume)
    return [each for each in found if all(time.size > 1 for time, _ in each.values())]
