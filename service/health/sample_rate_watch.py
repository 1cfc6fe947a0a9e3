"""The newest minute of yaw rate and torque as they came, to see whether they come often enough."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from incsvr.numerics import Array
from incsvr.signals.message_rates import SlowTorque, slow_torque
from incsvr.signals.streams import JUMP_S

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
