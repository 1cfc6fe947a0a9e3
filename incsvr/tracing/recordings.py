"""Recordings as the engine reads them: contiguous, each stream with its own stamps, and the clock that they share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from incsvr.numerics import Streams
from incsvr.plant.axes import of_rate
from incsvr.tracing.run import Run, pieces, stream


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
    """Recordings for the engine.

    Args:
        channels: to be read; `heading` is one.
        begin: the stamp of zero time where other recordings set it; None for the first stamp.
    """
    axis = runs[0].rate_name
    whole = [piece for run in runs for piece in pieces(run)]
    zero = min(float(piece.time[0]) for piece in whole) if begin is None else begin
    spans = sorted((float(run.time[0]), float(run.time[-1])) for run in runs)
    one_clock = all(a[1] <= b[0] for a, b in pairwise(spans))
    found = []
    for piece in whole:
        rate = stream(piece, piece.yaw_rate)
        own = {axis: rate, of_rate(axis).effort: stream(piece, piece.torque)}
        own |= {name: stream(piece, piece.channels[name]) for name in channels}
        if one_clock or begin is not None:  # what other recordings were fitted with is read here, too
            own["time"] = (rate[0], rate[0] - zero)
        found.append(own)
    names = (*channels, *(("time",) if one_clock else ()))
    return Recordings(axis, tuple(found), zero, one_clock, names)
