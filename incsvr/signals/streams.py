"""One stream of stamped values on its way in: ordered, bounded, and every refusal counted by its reason.

Whether a value is taken depends on the messages of its own stream alone, in the order in which that stream sent them,
and on their stamps: never on a clock, on other streams, or on how messages were bundled.
"""

from __future__ import annotations

import sys
from array import array
from bisect import bisect_left
from math import inf, isfinite
from typing import Any

import numpy as np

from incsvr.samples import Array

JUMP = 10.0
"""A stamp further ahead than this [s] waits for the next to confirm it: one wrong stamp must not deafen a stream."""
FUTURE = 1e11
"""Stamps from here on [s] are no time that any clock shows."""
CAPACITY = 200_000
"""Values that wait for the other streams at most; beyond, the oldest go."""
_CHUNK = 512


class Stream:
    """The values of one stream that are still needed, in the order of their stamps.

    Args:
        limit: largest magnitude that is plausible, in the stream's unit; infinite where every finite one is.
        lateness: how far behind the stream's newest stamp a value may come [s].
    """

    def __init__(self, limit: float, lateness: float) -> None:
        self.limit = min(limit, sys.float_info.max)
        self.lateness = lateness
        self.newest = -inf
        self.rejected: dict[str, int] = {}
        self._time = array("d")
        self._value = array("d")
        self._unconfirmed: tuple[float, float] | None = None

    @property
    def settled(self) -> float:
        """All values before this time [s] are known: what comes later with such a stamp is late."""
        return self.newest - self.lateness

    @property
    def first(self) -> float:
        """The oldest stamp still held [s]; infinite where none is."""
        return self._time[0] if self._time else inf

    def __len__(self) -> int:
        return len(self._time)

    def arrays(self) -> tuple[Array, Array]:
        """(n,) stamps [s] and (n,) values, as copies."""
        return np.array(self._time), np.array(self._value)

    def push(self, time: float, value: float) -> None:
        """Takes one value, or counts why not."""
        if not 0.0 <= time < FUTURE:
            self._reject("not_finite" if not isfinite(time) else "negative_time" if time < 0.0 else "implausible_time")
        elif not abs(value) <= self.limit:
            self._reject("implausible" if isfinite(value) else "not_finite")
        elif self._unconfirmed is None and 0.0 < time - self.newest <= JUMP:
            self._time.append(time)
            self._value.append(value)
            self.newest = time
        else:
            self._push_unusual(time, value)
        if len(self._time) > CAPACITY:
            self._reject("overflow", len(self._time) - CAPACITY * 7 // 8)
            self.forget(self._time[-CAPACITY * 7 // 8])

    def push_many(self, time: Array, value: Array) -> None:
        """Takes (n,) stamps and values: the same as one push for each, but quick where nothing is unusual."""
        for start in range(0, time.size, _CHUNK):
            stamps, values = time[start : start + _CHUNK], value[start : start + _CHUNK]
            if self._usual(stamps, values):
                self._time.frombytes(stamps.tobytes())
                self._value.frombytes(values.tobytes())
                self.newest = self._time[-1]
            else:
                for pair in zip(stamps.tolist(), values.tolist(), strict=True):
                    self.push(*pair)

    def forget(self, before: float) -> None:
        """Drops the values with stamps before this time [s]."""
        count = bisect_left(self._time, before)
        del self._time[:count]
        del self._value[:count]

    def to_dict(self) -> dict[str, Any]:
        """All that the stream holds, as plain data."""
        return {
            "newest": self.newest if isfinite(self.newest) else None,
            "time": self._time.tolist(),
            "value": self._value.tolist(),
            "unconfirmed": None if self._unconfirmed is None else list(self._unconfirmed),
            "rejected": dict(self.rejected),
        }

    def restore(self, data: dict[str, Any]) -> None:
        """Takes up what to_dict gave."""
        self.newest = -inf if data["newest"] is None else float(data["newest"])
        self._time, self._value = array("d", data["time"]), array("d", data["value"])
        waiting = data["unconfirmed"]
        self._unconfirmed = None if waiting is None else (float(waiting[0]), float(waiting[1]))
        self.rejected = {str(reason): int(count) for reason, count in data["rejected"].items()}

    def _push_unusual(self, time: float, value: float) -> None:
        """The first value, a clock that jumps, what comes out of order, late or twice."""
        if self._unconfirmed is not None:
            jumped, kept = self._unconfirmed
            self._unconfirmed = None
            if jumped - self.lateness <= time <= jumped + JUMP:
                self._time.append(jumped)
                self._value.append(kept)
                self.newest = jumped
            else:
                self._reject("clock_jump")
        if time - self.newest > JUMP:
            self._unconfirmed = (time, value)
        elif time < self.settled:
            self._reject("late")
        else:
            position = bisect_left(self._time, time)
            if position < len(self._time) and self._time[position] == time:
                self._reject("duplicate")
            else:
                self._time.insert(position, time)
                self._value.insert(position, value)
                self.newest = max(self.newest, time)

    def _usual(self, time: Array, value: Array) -> bool:
        """Whether push would append every single one of these."""
        if self._unconfirmed is not None or len(self._time) + time.size > CAPACITY:
            return False
        if not (time.min() >= 0.0 and time.max() < FUTURE and np.abs(value).max() <= self.limit):
            return False
        step = np.diff(time, prepend=self.newest)
        return bool(step.min() > 0.0 and step.max() <= JUMP)

    def _reject(self, reason: str, count: int = 1) -> None:
        self.rejected[reason] = self.rejected.get(reason, 0) + count
