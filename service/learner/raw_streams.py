"""The newest raw data of one learner, for all who look at measurements rather than at samples.

Measurements are pushed from any thread; anybody reads. What is no measurement is left out when it is read.
"""

from __future__ import annotations

import math
import threading
from array import array

import numpy as np

from incsvr.numerics import Array, Stream
from incsvr.signals import REQUIRED, TORQUE, YAW_RATE, SignalSettings

CAPACITY_VALUES = 200_000
"""Values of a stream that are kept at most: many batches wait to be learned where a recording is played quickly."""


class RawStreams:
    """The streams of a learner with these signals."""

    def __init__(self, signals: SignalSettings) -> None:
        self._lock = threading.Lock()
        self._limits = {YAW_RATE: signals.rate_limit, TORQUE: signals.torque_limit}
        self._raw = {stream: (array("d"), array("d")) for stream in (*REQUIRED, *signals.channels)}

    def push(self, stream: str, t: Array, value: Array) -> None:
        """Keeps (n,) stamps [s] and values of a stream; one that is not configured is left out."""
        if stream not in self._raw:
            return
        with self._lock:
            for kept, new in zip(self._raw[stream], (t, value), strict=True):
                kept.extend(new.tolist())
                if len(kept) > CAPACITY_VALUES:
                    del kept[: len(kept) - CAPACITY_VALUES // 2]

    def until(self, stream: str) -> float:
        """The stamp until which a stream has come [s], the middle one of three: one may be a mistake; −∞ before."""
        with self._lock:
            last = sorted(self._raw[stream][0][-3:])
        return last[1] if len(last) == 3 else -math.inf

    def read(self, stream: str, reach: float) -> Stream:
        """The measurements of a stream, by rising stamps, each once.

        Args:
            reach: how far from the newest stamps [s]. What is ahead of them by more is a mistake, what is behind by
                more is of the time before a clock began anew.
        """
        with self._lock:
            time, value = (np.array(kept) for kept in self._raw[stream])
        kept = np.isfinite(time) & np.isfinite(value) & (np.abs(value) <= self._limits.get(stream, math.inf))
        time, value = time[kept], value[kept]
        recent = float(np.median(time[-11:])) if time.size else 0.0
        near = np.abs(time - recent) <= reach
        unique, first = np.unique(time[near], return_index=True)
        return unique, value[near][first]

    def forget(self, before: float) -> None:
        """Drops what is older than a stamp [s]."""
        with self._lock:
            for time, value in self._raw.values():
                old = int(np.searchsorted(np.maximum.accumulate(np.array(time)), before))
                del time[:old], value[:old]
