"""One clock for all streams, message by message: the yaw rate's; the same rule as that of logs (`clocks`).

What shares that clock keeps its own stamps. What bears none, or those of another clock, is placed by when it arrives:
at the yaw rate's newest stamp, and later by what has gone by since that came.
"""

from __future__ import annotations

from collections import Counter, deque
from dataclasses import dataclass, field
from math import isfinite
from statistics import median

from service.inputs.clocks import MIN_APART_FROM_ZERO_S, SAME_CLOCK_S, WRAP_S
from service.inputs.source_binding import RATE

MAX_APART_S = 10.0
"""The distance from the yaw rate's stamps within which stamps are of its clock [s]: as for our own keys
(`incsvr.signals.streams.JUMP_S`), so that a publisher may be behind the other by that."""
MIN_LAG_S = 1.0
"""The lag behind the yaw rate's stamps that arrive with them from which on stamps are of another clock [s]: no bus
takes as long."""
LAG_MESSAGES = 21
"""Messages by which a lag is judged; their median does not mind a few that were held up."""
REAL_TIME_PACES = (0.5, 2.0)
"""The paces of the yaw rate's stamps over the wall's clock within which messages are no recording that is played."""
RESTART_MESSAGES = 5
"""Messages of the yaw rate that are behind in a row after a restart: one that is late over a second link rarely has as
many after it."""


@dataclass(slots=True)
class ClockOfRate:
    """The newest stamp of the yaw rate [s], and when it came; None before there is one."""

    newest: float | None = None
    came: float = 0.0
    _late: int = 0
    _zeros: Counter[str] = field(default_factory=Counter)
    _paces: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=LAG_MESSAGES))
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
            self._late = self._late + 1 if self.newest is not None and times[-1] < self.newest - SAME_CLOCK_S else 0
            if not 0 < self._late < RESTART_MESSAGES:
                self.newest, self.came = times[-1], arrival
                self._paces.append((times[-1], arrival))
        return times

    def behind(self, name: str) -> float | None:
        """The delay of a stream's stamps behind the yaw rate's that arrive with them [s], if it is implausible."""
        lags = self._behind.get(name)
        if lags is None or len(lags) < LAG_MESSAGES or len(self._paces) < LAG_MESSAGES:
            return None
        (first, began), (last, ended) = self._paces[0], self._paces[-1]
        real = REAL_TIME_PACES[0] * (ended - began) < last - first < REAL_TIME_PACES[1] * (ended - began)
        lag = median(lags)
        return lag if real and abs(lag) > MIN_LAG_S else None

    def doubts(self, name: str, own: bool, stamped: bool) -> list[str]:
        """The sentences on a stream's clock.

        Args:
            own: whether its own stamps count.
            stamped: whether its messages bear stamps.
        """
        if not own and stamped:
            return [f"the stamps of {name} are of another clock than those of yaw_rate: its times of arrival are used"]
        lag = self.behind(name)
        if lag is None:
            return []
        return [
            f"the stamps of {name} are {abs(lag):.2g} s {'behind' if lag > 0.0 else 'ahead of'} those of yaw_rate that "
            "arrive with them; if they come from another clock, set its stamp to arrival"
        ]

    def times_of(self, name: str, stamps: list[float] | None, arrival: float) -> tuple[list[float], bool]:
        """The times of another message [s], and whether they are its own stamps; none where nothing places it."""
        if self.newest is None:
            return stamps or [], True
        if stamps and not self._unset(name, stamps):
            # By how many turns of a 32-bit counter of microseconds the two are apart.
            apart = self.newest - stamps[-1]
            turns = round(apart / WRAP_S) if isfinite(apart) else 0
            if abs(apart - turns * WRAP_S) <= MAX_APART_S:
                lags = self._behind.setdefault(name, deque(maxlen=LAG_MESSAGES))
                lags.append(apart - turns * WRAP_S + arrival - self.came)
                return [stamp + turns * WRAP_S for stamp in stamps], True
            if len(stamps) > 1:
                return [], False
        return [self.newest + arrival - self.came], False

    def _unset(self, name: str, stamps: list[float]) -> bool:
        """Whether a driver set no stamp: a zero far from the clock, or one more, as in `without_unset` of logs."""
        if stamps != [0.0]:
            return False
        self._zeros[name] += 1
        return self._zeros[name] > 1 or (self.newest is not None and abs(self.newest) > MIN_APART_FROM_ZERO_S)
