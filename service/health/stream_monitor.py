"""The monitor of a learner's streams: counts and times of arrival, and the recent rejections."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from incsvr.numerics import Array
from incsvr.signals.streams import JUMP_S, MAX_STAMP_S, Reading
from service import wire
from service.health.sequence import Sequence


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
