"""Whole recordings through the synchroniser: the same samples as when they are played live."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from incsvr.numerics import Array, Streams
from incsvr.signals.samples import Samples
from incsvr.signals.settings import SignalSettings
from incsvr.signals.synchroniser import Synchroniser
from incsvr.signals.torque_takers import TakesTorque

_BLOCK_VALUES = 4096
"""Values of the longest stream that are pushed at once."""


def synchronise(
    settings: SignalSettings, streams: Streams, takes: TakesTorque | None = None
) -> tuple[Samples, Mapping[str, int]]:
    """All samples of whole streams without the torques of `takes`, and the refused values by reason.

    The same samples as when the streams are played live.

    Example:
        A vehicle at rest that a steady torque of 70 N m begins to turn with 0.2 rad/s², I = 350 kg m²: no damping.

        >>> clock = 0.02 * np.arange(300)
        >>> streams = {"yaw_rate": (clock, 0.2 * clock), "torque": (clock, np.full(300, 70.0))}
        >>> samples, refused = synchronise(SignalSettings(inertia=350.0, rate_limit=2.0), streams)
        >>> bool(np.abs(samples.damping).max() < 0.01), dict(refused)
        (True, {})
    """
    synchroniser = Synchroniser(settings, takes)
    return play(synchroniser, streams), synchroniser.rejected


def play(synchroniser: Synchroniser, streams: Streams) -> Samples:
    """All complete samples of whole streams, name → (stamps [s], values); the synchroniser can continue."""
    parts = []
    for chunks in _interleaved(streams):
        for name, time, value in chunks:
            synchroniser.push(name, time, value)
        parts.append(synchroniser.ready())
    return Samples.concatenate(parts)


def _interleaved(streams: Streams) -> Iterator[list[tuple[str, Array, Array]]]:
    """The streams cut into slices at the same times, so that none runs far ahead of the others."""
    clocks = {name: np.fmax.accumulate(time) for name, (time, _) in streams.items()}
    longest = max(clocks.values(), key=len, default=np.empty(0))
    cuts = longest[_BLOCK_VALUES::_BLOCK_VALUES]
    edges = {name: [0, *np.searchsorted(clock, cuts).tolist(), clock.size] for name, clock in clocks.items()}
    for part in range(cuts.size + 1):
        chunks: list[tuple[str, Array, Array]] = []
        for name, (time, value) in streams.items():
            share = slice(edges[name][part], edges[name][part + 1])
            chunks.append((name, time[share], value[share]))
        yield chunks
