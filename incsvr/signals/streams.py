"""One stream of stamped values on its way in: it has a clock of its own, is bounded, and counts every refusal.

Whether a value is taken depends on the messages of its own stream alone, in the order in which that stream sent them,
and on their stamps: never on a clock on the wall, on other streams, or on how messages were bundled.

What is right for each thing that a clock does:

- A stamp up to `lateness` behind the newest is put in its place. One further behind is late, and refused.
- A stamp more than JUMP_S away is doubted: it is held, and so is what follows on it. If the clock goes on where it was,
  all that is doubted is refused as `clock_jump`. If instead BELIEVED_STAMPS different stamps follow one another, the
  clock is where they say; the same stamp again proves nothing. Nothing that was held is lost then.
- A clock that is believed to be ahead goes on with the same stream: it had a pause.
- A clock that is believed to be back has begun anew (the sensor was switched off and on, or a wrong clock was put
  right). Its values are kept apart, as the stream's `next`, until the synchroniser knows what they belong to.
- A counter of 32 bits that wraps, in microseconds or milliseconds, goes on: what it lost is added from then on.

A wrong belief ends as it began: BELIEVED_STAMPS stamps of the right clock bring the stream back to it. No stamps,
however wrong or many, deafen a stream for longer than that.
"""

from __future__ import annotations

import sys
from array import array
from bisect import bisect_left
from dataclasses import dataclass
from math import inf, isfinite
from typing import Any

import numpy as np

from incsvr.numerics import Array
from incsvr.signals.bursts import bursts
from incsvr.signals.doubted_stamps import DoubtedStamps
from incsvr.signals.steps import MIN_STEP_S

JUMP_S = 10.0
"""Distance of a stamp from the newest beyond which it may be wrong, or of a clock that was set [s]."""
BELIEVED_STAMPS = 10
"""Different stamps, each later than those before, and none of the clock before in between, that are no mistake."""
FIRST_BELIEVED_STAMPS = 2
"""Stamps that are believed where no clock is known yet, and of a channel: it may come once in seconds, and no sample
hangs on it."""
WRAP_PERIODS_S = (2**32 / 1e6, 2**32 / 1e3)
"""Times after which a counter of 32 bits begins at zero [s]: of microseconds, of milliseconds."""
MAX_WRAP_PAUSE_S = 1.0
"""Longest pause [s] at which a clock that goes back by exactly such a time has wrapped."""
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
        began_anew: whether its clock began anew and the other streams' have not.
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
        believed: so many stamps that follow one another are believed against the clock so far.
        rejected: counts refusals by reason.
    """

    def __init__(
        self, limit: float, lateness: float, believed: int = BELIEVED_STAMPS, rejected: dict[str, int] | None = None
    ) -> None:
        self.limit = min(limit, sys.float_info.max)
        self.lateness = lateness
        self.believed = believed
        self.newest = -inf
        self.since = -inf
        """Since this stamp [s] its clock has not been set."""
        self.next: Stream | None = None
        """The values since its clock began anew."""
        self.rejected: dict[str, int] = {} if rejected is None else rejected
        self._time = array("d")
        self._value = array("d")
        self._doubted = DoubtedStamps()
        self._wrapped = 0.0  # what the counter lost by wrapping [s]

    @property
    def settled(self) -> float:
        """Marks all values before this time [s] as known: a later message with such a stamp is late."""
        return self.newest - self.lateness

    @property
    def first(self) -> float:
        """The oldest stamp still held [s]; infinite where none is."""
        return self._time[0] if self._time else inf

    @property
    def latest(self) -> Stream:
        """The stream as its clock is now: what began anew, where it did."""
        return self if self.next is None else self.next

    @property
    def held(self) -> int:
        """Values that are held, the doubted ones and those of a clock that began anew with them."""
        return len(self) + len(self._doubted) + (0 if self.next is None else self.next.held)

    def anew(self) -> Stream:
        """A stream of the same kind that holds nothing and goes on with its counts."""
        return Stream(self.limit, self.lateness, self.believed, self.rejected)

    def __len__(self) -> int:
        return len(self._time)

    def arrays(self) -> tuple[Array, Array]:
        """(n,) stamps [s] and (n,) values, as copies."""
        return np.array(self._time), np.array(self._value)

    def reading(self) -> Reading:
        """The present reading of the stream."""
        clock = self.latest
        steps = np.diff(clock._time[-PERIOD_STEPS - 1 :])
        return Reading(
            newest=clock.newest if isfinite(clock.newest) else None,
            period=float(np.median(steps)) if steps.size else None,
            longest=float(steps.max()) if steps.size else None,
            held=self.held,
            began_anew=self.next is not None,
            bursts=bursts(np.array(clock._time[-_CHUNK_VALUES:])),
        )

    def push(self, time: float, value: float) -> None:
        """Takes one value, or counts why not."""
        if not 0.0 <= time < MAX_STAMP_S:
            self.refuse("not_finite" if not isfinite(time) else "negative_time" if time < 0.0 else "implausible_time")
        elif not abs(value) <= self.limit:
            self.refuse("implausible" if isfinite(value) else "not_finite")
        elif self.next is not None:
            self.next.push(time, value)
            if self.next.next is not None:  # once more, alone: nothing will ever belong to what was between
                self.refuse("clocks_apart", len(self.next))
                self.next = self.next.next
        elif not self._doubted and MIN_STEP_S <= time + self._wrapped - self.newest <= JUMP_S:
            self.newest = time + self._wrapped
            self._time.append(self.newest)
            self._value.append(value)
        else:
            self._push_unusual(time, value)
        if len(self._time) > MAX_WAITING_VALUES:
            self.refuse("overflow", len(self._time) - MAX_WAITING_VALUES * 7 // 8)
            self.cut(self._time[-MAX_WAITING_VALUES * 7 // 8])

    def push_many(self, time: Array, value: Array) -> None:
        """Takes (n,) stamps and values: the same as one push for each, but quick where nothing is unusual."""
        for start in range(0, time.size, _CHUNK_VALUES):
            stamps, values = time[start : start + _CHUNK_VALUES], value[start : start + _CHUNK_VALUES]
            if time.size <= FEW_VALUES or not self.latest._extend(stamps, values):
                for pair in zip(stamps.tolist(), values.tolist(), strict=True):
                    self.push(*pair)

    def forget(self, before: float) -> None:
        """Drops the values with stamps before this time [s], but for those that tell the period there."""
        self._drop(max(bisect_left(self._time, before) - PERIOD_STEPS - 1, 0))

    def cut(self, before: float) -> None:
        """Drops all values with stamps before this time [s]."""
        self._drop(bisect_left(self._time, before))

    def count(self, low: float, high: float) -> int:
        """The number of values with stamps from `low` to before `high` [s]."""
        return max(bisect_left(self._time, high) - bisect_left(self._time, low), 0)

    def refuse(self, reason: str, count: int = 1) -> None:
        """Counts values that are not taken."""
        if count:
            self.rejected[reason] = self.rejected.get(reason, 0) + count

    def to_dict(self) -> dict[str, Any]:
        """The stream as plain data."""
        return {
            "newest": self.newest if isfinite(self.newest) else None,
            "since": self.since if isfinite(self.since) else None,
            "time": self._time.tolist(),
            "value": self._value.tolist(),
            "doubted": [list(pair) for pair in self._doubted.values],
            "advanced": self._doubted.advanced,
            "wrapped": self._wrapped,
            "rejected": dict(self.rejected),
            "next": None if self.next is None else self.next.to_dict(),
        }

    def restore(self, data: dict[str, Any]) -> None:
        """Takes up what to_dict gave."""
        self.newest = -inf if data["newest"] is None else float(data["newest"])
        self.since = -inf if data["since"] is None else float(data["since"])
        self._time, self._value = array("d", data["time"]), array("d", data["value"])
        doubted = [(float(time), float(value)) for time, value in data["doubted"]]
        self._doubted = DoubtedStamps(doubted, int(data["advanced"]))
        self._wrapped = float(data["wrapped"])
        self.rejected.clear()
        self.rejected.update({str(reason): int(count) for reason, count in data["rejected"].items()})
        if data["next"] is not None:
            self.next = self.anew()
            self.next.restore(data["next"])

    def _push_unusual(self, time: float, value: float) -> None:
        """The first value, a clock that jumps, what comes out of order, late or twice."""
        own = time + self._wrapped
        if not self.newest - JUMP_S <= own <= self.newest + JUMP_S:
            self._doubt(time, value)
            return
        self._refuse_doubted()
        position = bisect_left(self._time, own)
        if own < self.settled:
            self.refuse("late")
        elif any(abs(near - own) < MIN_STEP_S for near in self._time[max(position - 1, 0) : position + 1]):
            self.refuse("duplicate")
        else:
            self._time.insert(position, own)
            self._value.insert(position, value)
            self.newest = max(self.newest, own)

    def _doubt(self, time: float, value: float) -> None:
        """Holds a value that is far from the clock, and believes what so many say one after the other."""
        if self._doubted.has(time):
            self.refuse("duplicate")
            return
        # Of yaw rate and torque a first clock is told by stamps near each other: two alone may be one of them wrong.
        first = not isfinite(self.newest) and self.believed == BELIEVED_STAMPS
        if not self._doubted.followed_by(time, self.lateness, JUMP_S if first else inf):
            self._refuse_doubted()
        self._doubted.add(time, value)
        if self._doubted.advanced >= (self.believed if isfinite(self.newest) else FIRST_BELIEVED_STAMPS):
            self._believe(self._doubted.take())

    def _believe(self, doubted: list[tuple[float, float]]) -> None:
        """The clock is where the stamps are that were doubted."""
        begin = doubted[0][0] + self._wrapped
        wrap = next((wrap for wrap in WRAP_PERIODS_S if 0.0 < begin + wrap - self.newest <= MAX_WRAP_PAUSE_S), None)
        clock = self
        if wrap is not None:
            self._wrapped += wrap
        elif begin > self.newest:
            self.since = begin
        else:
            clock = self.next = self.anew()
            clock.since = doubted[0][0]
        clock._time.extend([time + clock._wrapped for time, _ in doubted])
        clock._value.extend([value for _, value in doubted])
        clock.newest = clock._time[-1]

    def _refuse_doubted(self) -> None:
        self.refuse("clock_jump", len(self._doubted.take()))

    def _extend(self, time: Array, value: Array) -> bool:
        """Takes all of these where push would append every single one; else none."""
        if self._doubted or self.next is not None or len(self._time) + time.size > MAX_WAITING_VALUES:
            return False
        if not (time.min() >= 0.0 and time.max() < MAX_STAMP_S and np.abs(value).max() <= self.limit):
            return False
        own = time + self._wrapped
        step = np.diff(own, prepend=self.newest)
        if not (step.min() >= MIN_STEP_S and step.max() <= JUMP_S):
            return False
        self._time.frombytes(own.tobytes())
        self._value.frombytes(value.tobytes())
        self.newest = self._time[-1]
        return True

    def _drop(self, count: int) -> None:
        del self._time[:count]
        del self._value[:count]
