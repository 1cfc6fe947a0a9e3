"""One clock for all streams of a bus, message by message: the newest stamp of the yaw rate, and when it came.

What shares that clock keeps its own stamps. What bears none, or those of another clock, is placed by when it arrives:
at the yaw rate's newest stamp, and later by what has gone by since that came.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import isfinite, isnan, nan

import numpy as np

from incsvr.numerics import Array
from service.inputs.clocks import MIN_APART_FROM_ZERO_S, PACES, SAME_CLOCK_S, WRAP_S, pace_note

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
KEPT_MESSAGES = 100
"""Messages of the yaw rate that are kept for commands which came before them, and wait for others of their moment."""
MIN_PACE_APART_LIVE = 0.1
"""How far a pace is from 1 before it is one, over `LAG_MESSAGES` [1]: they take a second, and a bus makes some
hundredths of it."""
Paces = deque[tuple[float, float]]
RATE = "yaw_rate"


@dataclass(frozen=True, slots=True)
class LiveClock:
    """The clock after the messages until now.

    Attributes:
        course: after the newest messages of the yaw rate, and before the first (4, m): its place among all messages,
            the newest stamp [s], NaN before there is one, when that arrived [s], and the pace.
        late: messages of the yaw rate in a row that are behind it.
        zeros: stamps of zero, by stream.
        paces: the newest stamps and when they came [s].
        behind: by how much the newest stamps of each other stream are behind it [s].
        others: the newest stamps of each other stream, and when they came [s].
    """

    course: Array = field(default_factory=lambda: np.array([[-np.inf], [nan], [0.0], [1.0]]))
    late: int = 0
    zeros: Mapping[str, int] = field(default_factory=dict)
    paces: tuple[tuple[float, float], ...] = ()
    behind: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    others: Mapping[str, tuple[tuple[float, float], ...]] = field(default_factory=dict)

    @property
    def newest(self) -> float:
        """The newest stamp of the yaw rate [s]; NaN before there is one."""
        return float(self.course[1, -1])

    def take(self, name: str, order: Array, arrival: Array, stamps: Array | None) -> tuple[LiveClock, Array, bool]:
        """The clock after messages of a stream, their times (n,) [s], NaN where nothing places them, and whether the
        last one's are its own stamps.

        Args:
            order: (n,) of the messages among all.
        """
        return (
            (*self._of_rate(order, arrival, stamps), True) if name == RATE else self._of(name, order, arrival, stamps)
        )

    def _of_rate(self, order: Array, arrival: Array, stamps: Array | None) -> tuple[LiveClock, Array]:
        """The clock after messages of the yaw rate, and their times (n,): their stamps, or when they arrived."""
        newest, came = self.course[1:3, -1].tolist()
        late, paces, course = self.late, Paces(self.paces, LAG_MESSAGES), list[tuple[float, float, float, float]]()
        zeros, times = self.zeros.get(RATE, 0), list[float]()
        given = arrival if stamps is None else stamps
        ends = [*(order[1:] != order[:-1]).tolist(), True]
        for number, at, time, ends_message in zip(order.tolist(), arrival.tolist(), given.tolist(), ends, strict=True):
            if stamps is not None and time == 0.0:
                zeros += 1
                if zeros > 1 or abs(newest) > MIN_APART_FROM_ZERO_S:
                    time = at if isnan(newest) else newest + at - came
            times.append(time)
            if ends_message and isfinite(time):
                late = late + 1 if time < newest - SAME_CLOCK_S else 0
                if not 0 < late < RESTART_MESSAGES:
                    newest, came = time, at
                    paces.append((time, at))
            course.append((number, newest, came, _pace(paces)))
        counts = {**self.zeros, RATE: zeros}
        went = np.concatenate((self.course[:, -KEPT_MESSAGES:], np.array(course).T), axis=1)
        return replace(self, course=went, late=late, zeros=counts, paces=tuple(paces)), np.array(times)

    def _of(self, name: str, order: Array, arrival: Array, stamps: Array | None) -> tuple[LiveClock, Array, bool]:
        """As `take`, for other messages."""
        at = np.searchsorted(self.course[0], order, side="right") - 1
        _, newest, came, paces = self.course[:, np.maximum(at, 0)]
        last = np.searchsorted(order, order, side="right") - 1
        several = last - np.searchsorted(order, order, side="left") > 0
        by_arrival = np.where(several, np.nan, newest + (arrival - came) * paces)
        if stamps is None:
            return self, by_arrival, bool(isnan(newest[-1]))
        known = ~np.isnan(newest)
        zero = (stamps == 0.0) & known
        count = self.zeros.get(name, 0) + np.cumsum(zero)
        unset = zero & ((count > 1) | (np.abs(newest) > MIN_APART_FROM_ZERO_S))
        # By how many turns of a 32-bit counter of microseconds the two are apart.
        apart = newest - stamps[last]
        turns = np.round(np.where(np.isfinite(apart), apart, 0.0) / WRAP_S)
        own = ~unset & (np.abs(apart - turns * WRAP_S) <= MAX_APART_S)
        times = np.where(known, np.where(own, stamps + turns * WRAP_S, by_arrival), stamps)
        ended = last == np.arange(order.size)
        ends = own & ended
        lags = (apart - turns * WRAP_S + arrival - came)[ends].tolist()
        behind = {**self.behind, name: (*self.behind.get(name, ()), *lags)[-LAG_MESSAGES:]}
        came_at = zip(stamps[ended].tolist(), arrival[ended].tolist(), strict=True)
        others = {**self.others, name: (*self.others.get(name, ()), *came_at)[-LAG_MESSAGES:]}
        clock = replace(self, zeros={**self.zeros, name: int(count[-1])}, behind=behind, others=others)
        return clock, times, bool(own[-1] or not known[-1])

    @property
    def pace(self) -> float:
        """Seconds of the yaw rate's stamps in a second of arrivals, over the newest messages; 1 about real time."""
        return _pace(self.paces)

    def lag(self, name: str) -> float | None:
        """The delay of a stream's stamps behind the yaw rate's that arrive with them [s], if it is implausible."""
        lags = self.behind.get(name, ())
        if len(lags) < LAG_MESSAGES or len(self.paces) < LAG_MESSAGES:
            return None
        (first, began), (last, ended) = self.paces[0], self.paces[-1]
        real = REAL_TIME_PACES[0] * (ended - began) < last - first < REAL_TIME_PACES[1] * (ended - began)
        lag = float(np.median(lags))
        return lag if real and abs(lag) > MIN_LAG_S else None

    def doubts(self, name: str, own: bool, stamped: bool) -> list[str]:
        """The sentences on a stream's clock.

        Args:
            own: whether its own stamps count.
            stamped: whether its messages bear stamps.
        """
        found = [pace_note(RATE, self.pace)] if not own and self.pace != 1.0 else []
        lag = self.lag(name)
        if not own and stamped:
            pace = _pace(self.others.get(name, ()))
            runs = "" if pace == 1.0 or self.pace != 1.0 else f", and run at {pace:.2g} times the speed of the arrivals"
            cure = f", as a simulator's do: send {RATE} with stamps of that clock" if runs else ""
            found.append(
                f"the stamps of {name} are of another clock than those of yaw_rate{runs}: its times of arrival are "
                f"used{cure}"
            )
        elif lag is not None:
            found.append(
                f"the stamps of {name} are {abs(lag):.2g} s {'behind' if lag > 0.0 else 'ahead of'} those of yaw_rate "
                "that arrive with them; if they come from another clock, set its stamp to arrival"
            )
        return found


def _pace(paces: Paces | tuple[tuple[float, float], ...]) -> float:
    if len(paces) < LAG_MESSAGES:
        return 1.0
    (first, began), (last, ended) = paces[0], paces[-1]
    found = (last - first) / (ended - began) if ended > began else 1.0
    return found if abs(found - 1.0) > MIN_PACE_APART_LIVE and PACES[0] < found < PACES[1] else 1.0
