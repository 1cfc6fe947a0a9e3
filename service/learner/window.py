"""The newest stretch of the raw streams: what tracing looks at, and what the learner is taught again from.

A value is taken or refused as the synchroniser does it, so that both know the same. The window is bounded in time, and
by `incsvr.signals.streams.MAX_WAITING_VALUES` in number; a stream of 50 Hz takes 1.5 MB where the window
is 900 s long.
"""

from __future__ import annotations

from incsvr.numerics import Array
from incsvr.signals import REQUIRED, SignalSettings
from incsvr.signals.streams import MAX_WAITING_VALUES, empty_streams

FULL_SHARE = 0.95
"""Share of its length from which the window counts as full: the first seconds of streams rarely begin together."""
KEPT_SHARE, FORGETTING_SHARE = 2.0, 2.05
"""Data that are kept, in the window's length, so that a window which ended while a trace was at work can still be asked
for; and the length at which older data are forgotten, many at once, because forgetting moves all that is kept."""


class Window:
    """The streams of the last `length` seconds of the vehicle's time: yaw rate, torque and configured channels."""

    def __init__(self, settings: SignalSettings, length: float) -> None:
        self._length = length
        self._streams = empty_streams(settings)

    def start_over(self) -> None:
        """Keeps the values of the clocks since one of them went back, because the synchroniser starts over."""
        begin = max(self._streams[name].since for name in REQUIRED)
        for stream in self._streams.values():
            stream.cut(begin, "clocks_apart")

    def push(self, name: str, time: Array, value: Array) -> None:
        """Takes (n,) stamps [s] and values of a stream; one that is not configured is left out."""
        stream = self._streams.get(name)
        if stream is None:
            return
        stream.push_many(time, value)
        if stream.newest - stream.first > FORGETTING_SHARE * self._length:
            stream.forget(stream.newest - KEPT_SHARE * self._length)

    @property
    def newest(self) -> float:
        """The stamp until which yaw rate and torque have come [s]; −∞ before they have."""
        return min(self._streams[name].newest for name in REQUIRED)

    def is_full(self, until: float) -> bool:
        """Whether yaw rate and torque reach back over the whole length before the time `until` [s], or hold as many
        values as are kept."""
        reach = [until - self._streams[name].first for name in REQUIRED]
        held = max(len(self._streams[name]) for name in REQUIRED)
        return min(reach) >= FULL_SHARE * self._length or held >= MAX_WAITING_VALUES * 3 // 4

    def streams(self, until: float | None = None) -> dict[str, tuple[Array, Array]]:
        """Name → (stamps [s], values) of every stream that came, as copies.

        Args:
            until: end of the window [s], before which none is older than its length; None for the newest stamp.
        """
        oldest = (self.newest if until is None else until) - self._length
        held = {name: stream.arrays() for name, stream in self._streams.items()}
        return {name: (t[t >= oldest], value[t >= oldest]) for name, (t, value) in held.items() if t.size}
