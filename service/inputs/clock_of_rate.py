"""One clock for all streams, message by message: the yaw rate's; the same rule as that of logs (`clocks`).

What shares that clock keeps its own stamps. What bears none, or those of another clock, is placed by when it arrives:
at the yaw rate's newest stamp, and later by what has gone by since that came.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

from service.inputs.clocks import WRAP

APART = 10.0
"""Stamps further from the yaw rate's are of another clock [s]: as for our own keys (`incsvr.signals.streams.JUMP`), so
that a publisher may be behind the other by that."""


@dataclass(slots=True)
class ClockOfRate:
    """The newest stamp of the yaw rate [s], and when it came; None before there is one."""

    newest: float | None = None
    came: float = 0.0

    def reference(self, stamps: list[float] | None, arrival: float) -> list[float]:
        """The times of a message of the yaw rate: its stamps, or when it arrived."""
        times = [arrival] if stamps is None else stamps
        if times and isfinite(times[-1]):
            self.newest, self.came = times[-1], arrival
        return times

    def placed(self, stamps: list[float] | None, arrival: float) -> tuple[list[float], bool]:
        """The times of another message [s], and whether they are its own stamps; none where nothing places it."""
        if self.newest is None:
            return stamps or [], True
        if stamps:
            # By how many turns of a 32-bit counter of microseconds the two are apart.
            apart = self.newest - stamps[-1]
            turns = round(apart / WRAP) if isfinite(apart) else 0
            if abs(apart - turns * WRAP) <= APART:
                return [stamp + turns * WRAP for stamp in stamps], True
            if len(stamps) > 1:
                return [], False
        return [self.newest + arrival - self.came], False
