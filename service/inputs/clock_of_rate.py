"""One clock for all streams, message by message: the yaw rate's; the same rule as that of logs (`clocks`).

What shares that clock keeps its own stamps. What bears none, or those of another clock, is placed by when it arrives:
at the yaw rate's newest stamp, and later by what has gone by since that came.
"""

from __future__ import annotations

from collections import Counter, deque
from dataclasses import dataclass, field
from math import isfinite
from statistics import median

from service.inputs.clocks import APART_FROM_ZERO, SAME, WRAP
from service.inputs.source_binding import RATE

APART = 10.0
"""Stamps further from the yaw rate's are of another clock [s]: as for our own keys (`incsvr.signals.streams.JUMP`), so
that a publisher may be behind the other by that."""


LATE = 1.0
"""Stamps that are behind the yaw rate's by more though they arrive together [s] are of another clock: no bus takes as
long."""
LOOKED_AT = 21
"""Messages by which that is judged; their median does not mind a few that were held up."""
REAL_TIME = (0.5, 2.0)
"""Pace of the yaw rate's stamps over the wall's clock within which messages are no recording that is played."""
LATE_IN_A_ROW = 5
"""Messages of the yaw rate that are behind in a row: one that is late over a second link rarely has as many after it,
after a restart all are."""


@dataclass(slots=True)
class ClockOfRate:
    """The newest stamp of the yaw rate [s], and when it came; None before there is one."""

    newest: float | None = None
    came: float = 0.0
    _late: int = 0
    _zeros: Counter[str] = field(default_factory=Counter)
    _paces: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=LOOKED_AT))
    _behind: dict[str, deque[float]] = field(default_factory=dict)

    def reference(self, stamps: list[float] | None, arrival: float) -> list[float]:
        """The times of a message of the yaw rate: its stamps, or when it arrived."""
        if stamps is None:
            times = [arrival]
        elif self._unset(RATE, stamps):
            times = [arrival if self.newest is None else self.newest + arrival - self.came]
        else:
            times = stamps
        if times and isfinite(times[-1]):
            self._late = self._late + 1 if self.newest is not None and times[-1] < self.newest - SAME else 0
            if not 0 < self._late < LATE_IN_A_ROW:
                self.newest, self.came = times[-1], arrival
                self._paces.append((times[-1], arrival))
        return times

    def behind(self, name: str) -> float | None:
        """By how much the stamps of a stream are behind the yaw rate's that arrive with them [s], if that is odd."""
        lags = self._behind.get(name)
        if lags is None or len(lags) < LOOKED_AT or len(self._paces) < LOOKED_AT:
            return None
        (first, began), (last, ended) = self._paces[0], self._paces[-1]
        real = REAL_TIME[0] * (ended - began) < last - first < REAL_TIME[1] * (ended - began)
        lag = median(lags)
        return lag if real and abs(lag) > LATE else None

    def doubts(self, name: str, own: bool, stamped: bool) -> list[str]:
        """What is to be said of a stream's clock.

        Args:
            own: whether its own stamps count.
            stamped: whether its messages bear stamps.
        """
        if not own and stamped:
            return [f"the stamps of {name} are of another clock than those of yaw_rate: its times of arrival count"]
        lag = self.behind(name)
        if lag is None:
            return []
        return [
            f"the stamps of {name} are {abs(lag):.2g} s {'behind' if lag > 0.0 else 'ahead of'} those of yaw_rate that "
            "arrive with them; if they are of another clock, set its stamp to arrival"
        ]

    def placed(self, name: str, stamps: list[float] | None, arrival: float) -> tuple[list[float], bool]:
        """The times of another message [s], and whether they are its own stamps; none where nothing places it."""
        if self.newest is None:
            return stamps or [], True
        if stamps and not self._unset(name, stamps):
            # By how many turns of a 32-bit counter of microseconds the two are apart.
            apart = self.newest - stamps[-1]
            turns = round(apart / WRAP) if isfinite(apart) else 0
            if abs(apart - turns * WRAP) <= APART:
                lags = self._behind.setdefault(name, deque(maxlen=LOOKED_AT))
                lags.append(apart - turns * WRAP + arrival - self.came)
                return [stamp + turns * WRAP for stamp in stamps], True
            if len(stamps) > 1:
                return [], False
        return [self.newest + arrival - self.came], False

    def _unset(self, name: str, stamps: list[float]) -> bool:
        """Whether a driver set no stamp: a zero far from the clock, or one more, as in `without_unset` of logs."""
        if stamps != [0.0]:
            return False
        self._zeros[name] += 1
        return self._zeros[name] > 1 or (self.newest is not None and abs(self.newest) > APART_FROM_ZERO)
