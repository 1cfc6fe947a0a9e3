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


def recordings_of(
    runs: Sequence[Run],
    channels: Sequence[str],
    begin: float | None = None,
    fewest: int = 5,  # samples of rate and effort in a piece
) -> Recordings:
    """Recordings for the engine.

    Args:
        channels: to be read; `heading` is one.
        begin: the stamp of zero time where other recordings set it; None for the first stamp.
    """
    axis = runs[0].rate_name
    zero = min(float(run.time[0]) for run in runs) if begin is None else begin
    spans = sorted((float(run.time[0]), float(run.time[-1])) for run in runs)
    one_clock = all(a[1] <= b[0] for a, b in pairwise(spans))
    found = []
    for run in runs:
        rate = stream(run, run.yaw_rate)
        own = {axis: rate, of_rate(axis).effort: stream(run, run.torque)}
        pair = tuple(own)
        own |= {name: stream(run, run.channels[name]) for name in channels}
        if one_clock or begin is not None:  # what other recordings were fitted with is read here, too
            own["time"] = (rate[0], rate[0] - zero)
        parts = without_pauses(own, pair, 10.0)
        found += [part for part in parts if min(part[name][0].size for name in pair) > fewest]
    names = (*channels, *(("time",) if one_clock else ()))
    return Recordings(axis, tuple(found), zero, one_clock, names)
