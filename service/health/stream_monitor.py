"""The monitor of a learner's streams: counts, losses and times of arrival, the newest minute, the recent rejections."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from incsvr.numerics import Array
from incsvr.signals.message_rates import SlowTorque, slow_torque
from incsvr.signals.streams import JUMP_S, MAX_STAMP_S, Reading
from service import wire

CAPACITY_VALUES = 1024
"""Values of a stream: a minute and more of what comes at 2 to 20 Hz."""
MIN_SPACING_S = 0.02
"""The time between two values that are kept [s]: no vehicle changes its yaw rate within ten times as long."""
MIN_SPAN_S = 20.0
"""The stretch in which the time scale of a motion is seen [s]; it is looked for again after half as much."""


@dataclass(slots=True)
class RecentStream:
    """One stream: stamps [s] that rise, and values."""

    t: list[float] = field(default_factory=list)
    value: list[float] = field(default_factory=list)

    def add(self, t: Array, value: Array) -> None:
        """(n,) more; what jumps to another time begins anew."""
        if self.t and not -1.0 < float(t[0]) - self.t[-1] < JUMP_S:
            self.t.clear()
            self.value.clear()
        last = self.t[-1] if self.t else -np.inf
        if t.size == 1:
            if float(t[0]) - last >= MIN_SPACING_S:
                self.t.append(float(t[0]))
                self.value.append(float(value[0]))
        else:
            place = np.floor(t / MIN_SPACING_S)
            step = place[1:] - place[:-1]
            if step.min() >= 0.0:  # in their order, as nearly all come: no need to sort them
                first = np.concatenate(([0], np.flatnonzero(step) + 1))
            else:
                _, first = np.unique(place, return_index=True)
            later = first[t[first] - last >= MIN_SPACING_S]
            self.t += t[later].tolist()
            self.value += value[later].tolist()
        if len(self.t) > 2 * CAPACITY_VALUES:
            del self.t[:-CAPACITY_VALUES], self.value[:-CAPACITY_VALUES]

    @property
    def stream(self) -> tuple[Array, Array]:
        return np.array(self.t[-CAPACITY_VALUES:]), np.array(self.value[-CAPACITY_VALUES:])


@dataclass(slots=True)
class SampleRateWatch:
    """Whether the torque comes too slowly for how fast the vehicle turns; looked at anew as the data goes on."""

    rate: RecentStream = field(default_factory=RecentStream)
    torque: RecentStream = field(default_factory=RecentStream)
    checked_at: float = -np.inf
    finding: SlowTorque | None = None

    def look(self) -> SlowTorque | None:
        if not self.torque.t or not self.rate.t:
            return None
        newest = self.torque.t[-1]
        if newest - self.torque.t[0] < MIN_SPAN_S or 0.0 <= newest - self.checked_at < 0.5 * MIN_SPAN_S:
            return self.finding
        self.checked_at, self.finding = newest, slow_torque(self.rate.stream, self.torque.stream)
        return self.finding


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

    def add(self, at: float, t: Array, value: Array) -> tuple[Array, Array]:
        """(n,) stamps [s] and values came at a time of the wall's clock [s], n at least 1; those that are believed."""
        self.received += t.size
        self.at = at
        believed = (t >= 0.0) & (t < MAX_STAMP_S) & np.isfinite(value)
        if not believed.all():
            t, value = t[believed], value[believed]
            if not t.size:
                return t, value
        if self.watches_stillness:
            self._follow_stillness(t, value)
        self.t, self.value = float(t[-1]), float(value[-1])
        return t, value

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
