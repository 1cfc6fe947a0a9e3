"""Long recordings as stretches, so that a trace takes bounded time and memory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from incsvr.model.scales import motion_scale
from incsvr.model.series import between, duration, values
from incsvr.numerics import Streams
from incsvr.tracing.recordings import Recordings


def bounded(
    recordings: Recordings,
    most: int = 24_000,  # samples of the velocity: eight minutes at 50 Hz, ten seconds of a core
    stretch: float = 12.0,  # time scales of the motion that a stretch lasts at least: several windows of a fit
) -> tuple[Recordings, float]:
    """Recordings of at most so many samples, in stretches spread evenly, and the share of time that remains."""
    axis, runs = recordings.axis, recordings.streams
    count, whole = values(runs, axis).size, duration(runs, axis)
    if count <= most:
        return recordings, 1.0
    share = most / count
    long = max(stretch * motion_scale(runs, axis), share * whole / 24.0)
    found = [part for run in runs for part in _stretches(run, axis, share, long)]
    return replace(recordings, streams=tuple(found)), duration(found, axis) / whole


def _stretches(run: Streams, axis: str, share: float, long: float) -> Sequence[Streams]:
    """Stretches of a recording, evenly spread, that make up a share of it."""
    begin, end = float(run[axis][0][0]), float(run[axis][0][-1])
    number = max(round(share * (end - begin) / long), 1)
    lasts = share * (end - begin) / number
    starts = begin + (end - begin - lasts) * (np.arange(number) + 0.5) / number
    return [{name: between(each, start, start + lasts) for name, each in run.items()} for start in starts.tolist()]
