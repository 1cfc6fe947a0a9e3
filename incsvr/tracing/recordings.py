"""Recordings as the engine reads them: contiguous, each stream with its own stamps, and the clock that they share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from incsvr.model.series import without_pauses
from incsvr.numerics import Streams
from incsvr.plant.axes import of_rate
from incsvr.tracing.run import Run, stream


@dataclass(frozen=True, slots=True)
class Recordings:
    """Recordings of one axis.

    Attributes:
        axis: its velocity.
        streams: of each contiguous piece.
        begin: stamp at which the channel `time` is zero [s].
        one_clock: whether the recordings follow one another, so that `time` is among the streams.
        channels: names that the engine may read besides.
    """

    axis: str
    streams: tuple[Streams, ...]
    begin: float
    one_clock: bool
    channels: tuple[str, ...]


def recordings_of(runs: Sequence[Run], channels: Sequence[str], begin: float | None = None) -> Recordings:
    """Recordings for the engine; `heading` may be one of the channels, the rest is as in `of_streams`."""
    axis, whole = runs[0].rate_name, []
    for run in runs:
        own = {axis: stream(run, run.yaw_rate), of_rate(axis).effort: stream(run, run.torque)}
        whole.append(own | {name: stream(run, run.channels[name]) for name in channels})
    return of_streams(axis, whole, channels, begin)


def of_streams(
    axis: str,
    whole: Sequence[Streams],
    channels: Sequence[str],
    begin: float | None = None,
    fewest: int = 5,  # samples of rate and effort in a piece
) -> Recordings:
    """Recordings for the engine.

    Args:
        axis: its velocity.
        whole: each recording's streams by the engine's names.
        channels: to be read.
        begin: the stamp of zero time where other recordings set it; None for the first stamp.
    """
    ends = [[(float(t[0]), float(t[-1])) for t, _ in run.values()] for run in whole]
    spans = sorted((min(first for first, _ in each), max(last for _, last in each)) for each in ends)
    zero = spans[0][0] if begin is None else begin
    one_clock = all(a[1] <= b[0] for a, b in pairwise(spans))
    pair, found = (axis, of_rate(axis).effort), list[Streams]()
    for run in whole:
        own = dict(run)
        if one_clock or begin is not None:  # what other recordings were fitted with is read here, too
            own["time"] = (run[axis][0], run[axis][0] - zero)
        parts = without_pauses(own, pair, 10.0)
        found += [part for part in parts if min(part[name][0].size for name in pair) > fewest]
    names = (*channels, *(("time",) if one_clock else ()))
    return Recordings(axis, tuple(found), zero, one_clock, names)
