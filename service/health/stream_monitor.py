"""The monitor of a learner's streams: counts, losses and times of arrival, their rates, the recent rejections."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from incsvr.numerics import Array
from incsvr.signals import TORQUE, YAW_RATE
from incsvr.signals.message_rates import SlowTorque, slow_torque
from incsvr.signals.streams import JUMP_S, MAX_STAMP_S, Reading
from service import wire
from service.learner.raw_streams import RawStreams

MIN_SPACING_S = 0.02
"""The time between two values that are looked at [s]: no vehicle changes its yaw rate within ten times as long."""
MIN_SPAN_S = 20.0
"""The stretch in which the time scale of a motion is seen [s]; it is looked for again after half as much."""
SPAN_S = 120.0
"""The stretch of data that is looked at [s]."""


@dataclass(slots=True)
class SampleRateWatch:
    """Whether the torque comes too slowly for how fast the vehicle turns; looked at anew as the data goes on."""

    checked_at: float = -np.inf
    finding: SlowTorque | None = None

    def look(self, raw: RawStreams) -> SlowTorque | None:
        newest = raw.until(TORQUE)
        if not np.isfinite(newest) or 0.0 <= newest - self.checked_at < 0.5 * MIN_SPAN_S:
            return self.finding
        self.checked_at = newest
        rate, torque = (_thinned(*raw.read(name, SPAN_S)) for name in (YAW_RATE, TORQUE))
        if rate[0].size and torque[0].size and newest - torque[0][0] >= MIN_SPAN_S:
            self.finding = slow_torque(rate, torque)
        return self.finding


def _thinned(t: Array, value: Array) -> tuple[Array, Array]:
    """(n,) stamps [s] that rise and values, without those that follow too soon."""
    _, first = np.unique(np.floor(t / MIN_SPACING_S), return_index=True)
    return t[first], value[first]


MAX_MISSING = 4096
"""Missing numbers that are remembered; those of a larger gap cannot be found again."""


class Sequence:
    """The number of lost messages of a stream, by the numbers that their sender gave them.

    Messages may come out of order. A number is lost when two messages after it came and it has not; one that comes
    later still is found again. Numbers that begin anew (the sender was restarted) are followed.
    """

    def __init__(self) -> None:
        self._highest: int | None = None
        self._last = 0
        self._missing: dict[int, None] = {}  # in their order
        self._overtaken = 0  # missing numbers that only the latest message has overtaken
        self._lost = 0  # and not remembered any more

    @property
    def lost(self) -> int:
        """Messages that have not come."""
        return self._lost + len(self._missing) - self._overtaken

    def add(self, number: int) -> None:
        """A message with this number came."""
        highest, self._overtaken = self._highest, 0
        again = highest is not None and number <= highest and number not in self._missing
        if highest is None or (again and (number == self._last + 1 or number < highest - MAX_MISSING)):
            self._begin(number)
        elif number > highest:
            first = max(highest + 1, number - MAX_MISSING)
            self._lost += first - highest - 1
            self._missing.update(dict.fromkeys(range(first, number)))
            while len(self._missing) > MAX_MISSING:
                del self._missing[next(iter(self._missing))]
                self._lost += 1
            self._overtaken, self._highest = number - first, number
        else:
            self._missing.pop(number, None)
        self._last = number

    def _begin(self, number: int) -> None:
        """The first number, or the first after the sender began anew."""
        self._lost += len(self._missing)
        self._missing.clear()
        self._highest = number


@dataclass(slots=True)
class StreamMonitor:
    """One stream."""

    watches_stillness: bool = False  # whether it is followed since when its value has been the same
    received: int = 0  # values
    sequence: Sequence = field(default_factory=Sequence)
    at: float | None = None  # wall time of the newest message
    t: float | None = None  # the vehicle's time of it
    value: float | None = None
    still_since: float | None = None  # the vehicle's time since which the value has been the same

    def add(self, at: float, t: Array, value: Array) -> None:
        """(n,) stamps [s] and values came at a time of the wall's clock [s], n at least 1."""
        self.received += t.size
        self.at = at
        believed = (t >= 0.0) & (t < MAX_STAMP_S) & np.isfinite(value)
        if not believed.all():
            t, value = t[believed], value[believed]
            if not t.size:
                return
        if self.watches_stillness:
            self._follow_stillness(t, value)
        self.t, self.value = float(t[-1]), float(value[-1])

    def _follow_stillness(self, t: Array, value: Array) -> None:
        """Since when the value has been the same, as of these stamps (n,) [s] and values; over a jump of the clock
        nothing is known."""
        changed = np.flatnonzero((value[1:] != value[:-1]) | (np.abs(np.diff(t)) > JUMP_S))
        if changed.size:
            self.still_since = float(t[changed[-1] + 1])
        elif value[0] != self.value or self.t is None or abs(float(t[0]) - self.t) > JUMP_S:
            self.still_since = float(t[0])

    def health(self, now: float, reading: Reading | None) -> wire.StreamHealth:
        """The stream's part of health at a time of the wall's clock [s]."""
        return wire.StreamHealth(
            received=self.received,
            lost=self.sequence.lost,
            age_s=None if self.at is None else round(max(now - self.at, 0.0), 3),
            t=self.t,
            value=self.value,
            period_s=None if reading is None else reading.period,
            held=0 if reading is None else reading.held,
        )


@dataclass(slots=True)
class RecentRejections:
    """The recent rejections, by reason."""

    total: Mapping[str, int] = field(default_factory=dict)
    growth: dict[str, tuple[float, int]] = field(default_factory=dict)  # when it last grew [s], and by how much

    def look(self, now: float, rejected: Mapping[str, int], remembered_for: float) -> dict[str, int]:
        """Reason → how many, at a time of the wall's clock [s] at which so many were rejected since the start."""
        for reason in rejected.keys() | self.total.keys():
            grown = rejected.get(reason, 0) - self.total.get(reason, 0)
            at, before = self.growth.get(reason, (now, 0))
            remembered = before if now - at <= remembered_for else 0
            if grown > 0:
                self.growth[reason] = (now, remembered + grown)
            elif grown < 0:  # messages that were overtaken, and not lost
                self.growth[reason] = (at, remembered + grown)
        self.total = rejected
        return {
            reason: count
            for reason, (at, count) in sorted(self.growth.items())
            if count > 0 and now - at <= remembered_for
        }
