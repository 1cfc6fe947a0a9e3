"""Long recordings with fewer samples, so that a trace takes bounded time and memory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from incsvr.model.scales import motion_scale
from incsvr.model.series import duration, period, values
from incsvr.model_trace.recordings import Recordings
from incsvr.numerics import Stream, Streams


def thinned(
    recordings: Recordings,
    standing: float,
    most: int = 8_000,  # samples of the velocity: thirteen minutes at 10 Hz
    a_scale: float = 20.0,  # merged samples in a time scale of the motion
    stretch: float = 12.0,  # time scales that a stretch lasts at least: several windows of a fit
) -> tuple[Recordings, float]:
    """Recordings of at most so many samples, and the share of their time that remains.

    Neighbouring samples are merged while a command between them stays; of what is then too long, stretches are cut
    that are spread evenly.

    Args:
        standing: the usual time between changes of the effort [s], which may answer what came before them.
    """
    axis, runs = recordings.axis, list(recordings.streams)
    count = values(runs, axis).size
    if count <= most:
        return recordings, 1.0
    scale, sample = motion_scale(runs, axis), period(runs, axis)
    together = int(np.clip(min(scale / a_scale, 0.5 * standing) / sample, 1.0, np.ceil(count / most)))
    if together > 1:
        runs = [{**run, axis: merged(run[axis], together)} for run in runs]
        count = values(runs, axis).size
    if count <= most:
        return replace(recordings, streams=tuple(runs)), 1.0
    whole = duration(runs, axis)
    share = most / count
    long = max(stretch * scale, share * whole / 24.0)
    found = [part for run in runs for part in _stretches(run, axis, share, long)]
    return replace(recordings, streams=tuple(found)), duration(found, axis) / whole


def merged(stream: Stream, count: int) -> Stream:
    """Means of so many neighbouring samples at their mean stamps."""
    t, v = (each[: each.size // count * count].reshape(-1, count).mean(axis=1) for each in stream)
    return np.asarray(t), np.asarray(v)


def _stretches(run: Streams, axis: str, share: float, long: float) -> Sequence[Streams]:
    """Stretches of a recording, evenly spread, that make up a share of it."""
    begin, end = float(run[axis][0][0]), float(run[axis][0][-1])
    number = max(round(share * (end - begin) / long), 1)
    lasts = share * (end - begin) / number
    starts = begin + (end - begin - lasts) * (np.arange(number) + 0.5) / number
    return [{name: _between(each, start, start + lasts) for name, each in run.items()} for start in starts.tolist()]


def _between(stream: Stream, first: float, last: float) -> Stream:
    """The samples from one instant to another, with the one before, which may still act."""
    t, v = stream
    a, b = max(int(np.searchsorted(t, first, side="right")) - 1, 0), int(np.searchsorted(t, last, side="right"))
    return t[a:b], v[a:b]
