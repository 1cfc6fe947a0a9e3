"""The newest stretch of the raw streams: what tracing looks at, and what the learner is taught again from.

A value is taken or refused as the synchroniser does it, so that both know the same. The window is bounded in time, and
by `incsvr.signals.streams.MAX_WAITING_VALUES` in number; a stream of 50 Hz takes 0.7 MB in 900 s.
"""

from __future__ import annotations

from incsvr.numerics import Array
from incsvr.signals import REQUIRED, SignalSettings
from incsvr.signals.clocks import empty_streams
from incsvr.signals.streams import MAX_WAITING_VALUES

_FORGETTING_SLACK = 1.05  # forgetting moves all that is kept, so it is done once for many values


class Window:
    """What came within the last `length` seconds of the vehicle's time: yaw rate, torque and configured channels."""

    def __init__(self, settings: SignalSettings, length: float) -> None:
        self._length = length
        self._streams = empty_streams(settings)

    def switch_clocks(self) -> None:
        """Goes on with the clocks that began anew, because the synchroniser does."""
        self._streams = {name: stream.latest for name, stream in self._streams.items()}
        begin = max(self._streams[name].since for name in REQUIRED)
        for stream in self._streams.values():
            stream.cut(begin)

    def push(self, name: str, time: Array, value: Array) -> None:
        """Takes (n,) stamps [s] and values of a stream; one that is not configured is left out."""
        stream = self._streams.get(name)
        if stream is None:
            return
        stream.push_many(time, value)
        if stream.newest - stream.first > _FORGETTING_SLACK * self._length:
            stream.forget(stream.newest - self._length)

    @property
    def newest(self) -> float:
        """The stamp until which yaw rate and torque have come [s]; −∞ before they have."""
        return min(self._streams[name].newest for name in REQUIRED)

    @property
    def full(self) -> bool:
        """Whether yaw rate and torque reach back over the whole length, or hold as many values as are kept."""
        reach = [self.newest - self._streams[name].first for name in REQUIRED]
        held = max(len(self._streams[name]) for name in REQUIRED)
        return min(reach) >= self._length / _FORGETTING_SLACK or held >= MAX_WAITING_VALUES * 3 // 4

    def streams(self) -> dict[str, tuple[Array, Array]]:
        """Name → (stamps [s], values) of every stream that came, as copies, none older than the window."""
        oldest = self.newest - self._length
        held = {name: stream.arrays() for name, stream in self._streams.items()}
        return {name: (t[t >= oldest], value[t >= oldest]) for name, (t, value) in held.items() if t.size}
