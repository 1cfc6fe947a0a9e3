"""One stream of stamped values on its way in: it has a clock of its own, is bounded, and counts every refusal.

Whether a value is taken depends on the messages of its own stream alone, in the order in which that stream sent them,
and on their stamps: never on a clock on the wall, on other streams, or on how messages were bundled.

What is right for each thing that a clock does:

- A stamp up to `lateness` behind the newest is put in its place. One further behind is late, and refused.
- A stamp more than JUMP_S away waits. If the clock goes on where it was, what waits is refused as `clock_jump`. If
  CONFIRMING_STAMPS stamps follow one another, the clock is where they say; the same stamp again confirms nothing.
- A clock that is confirmed ahead goes on with the same stream: it had a pause.
- A clock that is confirmed back has begun anew (the sensor was switched off and on, a counter of 32 bits wrapped, a
  wrong clock was put right). The stream starts over with the confirming values; what it held before is refused.

A wrong clock ends as it began: CONFIRMING_STAMPS stamps of the right one bring the stream back to it. No stamps,
however wrong or many, deafen a stream for longer than that.
"""

from __future__ import annotations

import sys
from array import array
from bisect import bisect_left, insort
from dataclasses import dataclass
from math import inf, isfinite
from typing import Any

import numpy as np

from incsvr.numerics import Array
from incsvr.signals.bursts import bursts
from incsvr.signals.settings import TORQUE, YAW_RATE, SignalSettings
from incsvr.signals.steps import MIN_STEP_S

JUMP_S = 10.0
"""Distance of a stamp from the newest beyond which it may be wrong, or of a clock that was set [s]."""
CONFIRMING_STAMPS = 10
"""Different stamps, each later than the one before but for `lateness` and none of the present clock in between, that
confirm a clock elsewhere."""
FIRST_STAMPS = 2
"""Stamps that confirm a stream's first clock, and any of a channel: it may come once in seconds, and no sample depends
on it."""
MAX_STAMP_S = 1e11
"""Stamp from which on it is no time that any clock shows [s]."""
MAX_WAITING_VALUES = 200_000
"""Values that wait for the other streams at most; beyond, the oldest go."""
PERIOD_STEPS = 32
"""Steps between stamps that tell the period of a stream; their stamps are kept."""
FEW_VALUES = 16
"""Values up to which one push each is quicker than the calls that see whether anything is unusual among them."""
_CHUNK_VALUES = 512
"""Values of a stream that are taken at once, and the newest whose stamps tell whether it comes in bursts."""


@dataclass(frozen=True, slots=True)
class Reading:
    """The present reading of a stream.

    Attributes:
        newest: the newest stamp of its clock [s]; None before one is known.
        period: the median of its latest steps [s]; None before there are any.
        longest: the longest of them [s].
        bursts: how far apart the bursts are in which its values are stamped [s]; None where they are not.
        held: values that came, and are neither refused nor past the samples that they belong to.
        began_anew: whether its clock went back, and samples have not started over since.
    """

    newest: float | None
    period: float | None
    longest: float | None
    held: int
    began_anew: bool
    bursts: float | None = None


class Stream:
    """The values of one stream that are still needed, in the order of their stamps.

    Args:
        limit: largest magnitude that is plausible, in the stream's unit; infinite where every finite one is.
        lateness: how far behind the stream's newest stamp a value may come [s].
        confirming: so many stamps that follow one another confirm a clock elsewhere.
    """

    def __init__(self, limit: float, lateness: float, confirming: int = CONFIRMING_STAMPS) -> None:
        self.limit = min(limit, sys.float_info.max)
        self.lateness = lateness
        self.confirming = confirming
        self.newest = -inf
        self.since = -inf
        """Since this stamp [s] its clock has not been set."""
        self.began_anew = False
        """Whether its clock went back; the synchroniser, which knows the other clocks, resets it."""
        self.seen = -inf
        """Samples saw its values before this stamp [s]."""
        self.rejected: dict[str, int] = {}
        """The number of refusals by reason."""
        self._time = array("d")
        self._value = array("d")
        self._beyond: list[tuple[float, float]] = []  # stamps and values that wait to be confirmed

    @property
    def settled(self) -> float:
        """Marks all values before this time [s] as known: a later message with such a stamp is late."""
        return self.newest - self.lateness

    @property
    def first(self) -> float:
        """The oldest stamp still held [s]; infinite where none is."""
        return self._time[0] if self._time else inf

    @property
    def held(self) -> int:
        """Values that are held, those among them that wait to be confirmed."""
        return len(self) + len(self._beyond)

    def clear(self) -> None:
        """Drops all values and the clock."""
        self._refuse_beyond()
        self.cut(inf, "clock_jump")
        self.newest = self.seen = -inf

    def __len__(self) -> int:
        return len(self._time)

    def arrays(self) -> tuple[Array, Array]:
        """(n,) stamps [s] and (n,) values, as copies."""
        return np.array(self._time), np.array(self._value)

    def reading(self) -> Reading:
        """The present reading of the stream."""
        steps = np.diff(self._time[-PERIOD_STEPS - 1 :])
        return Reading(
            newest=self.newest if isfinite(self.newest) else None,
            period=float(np.median(steps)) if steps.size else None,
            longest=float(steps.max()) if steps.size else None,
            held=self.held,
            began_anew=self.began_anew,
            bursts=bursts(np.array(self._time[-_CHUNK_VALUES:])),
        )

    def push(self, time: float, value: float) -> None:
        """Takes one value, or counts why not."""
        if not 0.0 <= time < MAX_STAMP_S:
            self.refuse("not_finite" if not isfinite(time) else "negative_time" if time < 0.0 else "implausible_time")
        elif not abs(value) <= self.limit:
            self.refuse("implausible" if isfinite(value) else "not_finite")
        elif not self._beyond and MIN_STEP_S <= time - self.newest <= JUMP_S:
            self.newest = time
            self._time.append(time)
            self._value.append(value)
        else:
            self._push_unusual(time, value)
        if len(self._time) > MAX_WAITING_VALUES:
            self.refuse("overflow", len(self._time) - MAX_WAITING_VALUES * 7 // 8)
            self._drop(len(self._time) - MAX_WAITING_VALUES * 7 // 8)

    def push_many(self, time: Array, value: Array) -> None:
        """Takes (n,) stamps and values: the same as one push for each, but quick where nothing is unusual."""
        for start in range(0, time.size, _CHUNK_VALUES):
            stamps, values = time[start : start + _CHUNK_VALUES], value[start : start + _CHUNK_VALUES]
            if time.size <= FEW_VALUES or not self._extend(stamps, values):
                for pair in zip(stamps.tolist(), values.tolist(), strict=True):
                    self.push(*pair)

    def forget(self, before: float) -> None:
        """Drops the values with stamps before this time [s], but for those that tell the period there."""
        self._drop(max(bisect_left(self._time, before) - PERIOD_STEPS - 1, 0))

    def cut(self, before: float, reason: str) -> None:
        """Drops all values with stamps before this time [s]; those that no sample saw are refused."""
        count = bisect_left(self._time, before)
        self.refuse(reason, max(count - bisect_left(self._time, self.seen), 0))
        self._drop(count)

    def refuse(self, reason: str, count: int = 1) -> None:
        """Counts values that are not taken."""
        if count:
            self.rejected[reason] = self.rejected.get(reason, 0) + count

    def to_dict(self) -> dict[str, Any]:
        """The stream as plain data."""
        return {
            "newest": self.newest if isfinite(self.newest) else None,
            "since": self.since if isfinite(self.since) else None,
            "seen": self.seen if isfinite(self.seen) else None,
            "time": self._time.tolist(),
            "value": self._value.tolist(),
            "beyond": [list(pair) for pair in self._beyond],
            "began_anew": self.began_anew,
            "rejected": dict(self.rejected),
        }

    def restore(self, data: dict[str, Any]) -> None:
        """Takes up what to_dict gave."""
        self.newest = -inf if data["newest"] is None else float(data["newest"])
        self.since = -inf if data["since"] is None else float(data["since"])
        self.seen = -inf if data["seen"] is None else float(data["seen"])
        self._time, self._value = array("d", data["time"]), array("d", data["value"])
        self._beyond = [(float(time), float(value)) for time, value in data["beyond"]]
        self.began_anew = bool(data["began_anew"])
        self.rejected = {str(reason): int(count) for reason, count in data["rejected"].items()}

    def _push_unusual(self, time: float, value: float) -> None:
        """The first value, a clock that jumps, what comes out of order, late or twice."""
        if not self.newest - JUMP_S <= time <= self.newest + JUMP_S:
            self._push_beyond(time, value)
            return
        self._refuse_beyond()
        position = bisect_left(self._time, time)
        if time < self.settled:
            self.refuse("late")
        elif any(abs(near - time) < MIN_STEP_S for near in self._time[max(position - 1, 0) : position + 1]):
            self.refuse("duplicate")
        else:
            self._time.insert(position, time)
            self._value.insert(position, value)
            self.newest = max(self.newest, time)

    def _push_beyond(self, time: float, value: float) -> None:
        """Keeps a value that is far from the clock, and goes where so many stamps in their order say that it is."""
        if any(abs(stamp - time) < MIN_STEP_S for stamp, _ in self._beyond):
            self.refuse("duplicate")
            return
        first, step = not isfinite(self.newest), time - self._beyond[-1][0] if self._beyond else 0.0
        # Of yaw rate and torque two stamps that are near each other are a first clock: one of two others may be wrong.
        far = JUMP_S if first and self.confirming == CONFIRMING_STAMPS else inf
        other_side = bool(self._beyond) and (time > self.newest) != (self._beyond[0][0] > self.newest)
        if other_side or not -self.lateness <= step <= far:
            self._refuse_beyond()
        insort(self._beyond, (time, value))
        if len(self._beyond) >= (FIRST_STAMPS if first else self.confirming):
            self._follow(self._beyond)
            self._beyond = []

    def _follow(self, confirmed: list[tuple[float, float]]) -> None:
        """The clock is where these stamps are."""
        if confirmed[0][0] < self.newest:
            self.cut(inf, "clock_jump")
            self.began_anew, self.seen = True, -inf
        if isfinite(self.newest):
            self.since = confirmed[0][0]
        self._time.extend([time for time, _ in confirmed])
        self._value.extend([value for _, value in confirmed])
        self.newest = self._time[-1]

    def _refuse_beyond(self) -> None:
        self.refuse("clock_jump", len(self._beyond))
        self._beyond = []

    def _extend(self, time: Array, value: Array) -> bool:
        """Takes all of these where push would append every single one; else none."""
        if self._beyond or len(self._time) + time.size > MAX_WAITING_VALUES:
            return False
        if not (time.min() >= 0.0 and time.max() < MAX_STAMP_S and np.abs(value).max() <= self.limit):
            return False
        step = np.diff(time, prepend=self.newest)
        if not (step.min() >= MIN_STEP_S and step.max() <= JUMP_S):
            return False
        self._time.frombytes(time.tobytes())
        self._value.frombytes(value.tobytes())
        self.newest = self._time[-1]
        return True

    def _drop(self, count: int) -> None:
        del self._time[:count]
        del self._value[:count]


def empty_streams(settings: SignalSettings) -> dict[str, Stream]:
    """Empty streams of what samples wait for, by name."""
    return {
        YAW_RATE: Stream(settings.rate_limit, settings.lateness),
        TORQUE: Stream(settings.torque_limit, settings.lateness),
        **{name: channel(settings) for name in settings.channels},
    }


def channel(settings: SignalSettings) -> Stream:
    """The stream of a channel, which may come slowly."""
    return Stream(inf, settings.lateness, FIRST_STAMPS)
