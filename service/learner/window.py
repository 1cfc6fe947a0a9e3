"""The newest stretch of the raw streams, and the motion of the last few batches.

The window is what tracing looks at, and what the learner is taught again from. A value is taken or refused as the
synchroniser does it, so that both know the same. It is bounded in time, and by
`incsvr.signals.streams.MAX_WAITING_VALUES` in number; a stream of 50 Hz takes 1.5 MB where it is 900 s long.
"""

from __future__ import annotations

from collections import deque

from incsvr.checks.resolution import ResolutionFault, resolution_fault
from incsvr.learning.excitation import Excitation
from incsvr.numerics import Array
from incsvr.signals import REQUIRED, SignalSettings
from incsvr.signals.samples import Samples
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


RECENT_BATCHES = 5
"""Batches by which is judged whether the vehicle moves enough to be learned, and no quicker than the streams show."""


class RecentBatches:
    """The recent batches of one learner; `add` is called by the thread that learns, all else by any."""

    def __init__(self) -> None:
        self._excitation: deque[Excitation] = deque(maxlen=RECENT_BATCHES)
        self._samples: deque[Samples] = deque(maxlen=RECENT_BATCHES)
        self._trained: deque[bool] = deque(maxlen=RECENT_BATCHES)
        self.unresolved: ResolutionFault | None = None
        """The fault of motion that is too fast for the streams."""
        self.without_evidence_since: float | None = None
        """The first stamp of these batches [s], if hardly any of their motion was evidence and none trained a model."""

    def add(self, excitation: Excitation, batch: Samples, smoothing: float, trained: bool) -> None:
        """A batch was taken, of samples that were smoothed over so long [s]; `trained` if a model was made of it."""
        self._excitation.append(excitation)
        self._samples.append(batch)
        self._trained.append(trained)
        taught_nothing = len(self._trained) == RECENT_BATCHES and not any(self._trained)
        little = Excitation.together(tuple(self._excitation)).little
        self.without_evidence_since = float(self._samples[0].time[0]) if taught_nothing and little else None
        self.unresolved = resolution_fault(Samples.concatenate(tuple(self._samples)), smoothing)

    @property
    def excitation(self) -> Excitation | None:
        """The share of these batches that was evidence about damping; None before the first."""
        parts = tuple(self._excitation)
        return Excitation.together(parts) if parts else None
