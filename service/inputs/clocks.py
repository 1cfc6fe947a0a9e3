"""One clock for all streams: each stamp where the vehicle's own clock has it, whoever wrote it down and whenever.

A vehicle's messages bear its clock, in different units, some of which run over; others bear none, and only the log's
time of arrival tells when they were. The yaw rate's stamps are the reference: what shares their clock keeps its own
stamps, everything else is placed by its arrival. Both clocks may be set under way, and the vehicle may start anew.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array
from service.inputs.table import Table

WRAP_S = 2.0**32 * 1e-6
"""The time after which a stamp of 32 bits in µs begins anew [s]."""
SAME_CLOCK_S = 1.0
"""The difference within which clocks are one clock [s]: the rest is the way of the messages."""
MIN_APART_FROM_ZERO_S = 60.0
"""The distance from zero of all other stamps from which on a single stamp of zero is none [s]."""
MAX_DELAY_S = 60.0
"""The time after its stamp by which a message comes [s]; one that comes later bears a wrong one."""
MIN_LEAP_S = 86_400.0
"""The pause within one log that is none, a day [s]: the clock was set, as by GPS after a start in 1970."""
DELAY_MESSAGES = 21
"""Messages by which the way from stamp to arrival is judged: some of them come on time, also over a second link."""


@dataclass(frozen=True, slots=True)
class Clock:
    """The reference, message by message.

    Attributes:
        arrival: (m,) when its messages arrived [s], not falling.
        apart: (m,) arrival minus stamp of a message that is on time [s].
        shift: (m,) what makes one time that goes on of the stamps [s].
        sets: when the log's clock was set, on that time [s].
        pace: seconds of the stamps in a second of the log's clock; arrivals are counted at this pace.
        origin: the arrival from which they are [s].
        of_arrival: whether its stream bears no stamps.
    """

    arrival: Array
    apart: Array
    shift: Array
    sets: tuple[float, ...] = ()
    pace: float = 1.0
    origin: float = 0.0
    of_arrival: bool = False

    @staticmethod
    def of(arrival: Array, stamps: Array | None) -> Clock:
        """The clock of a stream (n,) [s]; without stamps the clock is that of arrival."""
        given = np.isfinite(arrival) if stamps is None else np.isfinite(arrival) & np.isfinite(stamps)
        if stamps is not None and not given.any():
            return Clock.of(arrival, None)
        arrival, of_arrival = arrival[given], stamps is None
        stamps = arrival if stamps is None else stamps[given]
        if not arrival.size:
            return Clock(np.zeros(1), np.zeros(1), np.zeros(1))
        found, origin = pace(arrival, stamps), float(arrival[0])
        arrival = origin + (arrival - origin) * found
        apart = arrival - stamps
        begins = _without_late(_jumps(apart), apart, stamps)
        level = np.concatenate([_level(piece, found != 1.0) for piece in np.split(apart, begins)])
        jumps = np.isin(np.arange(apart.size), begins)
        came, went = np.diff(arrival, prepend=arrival[:1]), np.diff(stamps, prepend=stamps[:1])
        by_log = jumps & ((came > MIN_LEAP_S) | (came < -SAME_CLOCK_S))
        both = (came > MIN_LEAP_S) & (went > MIN_LEAP_S)
        moved = np.where(jumps & ~by_log, np.diff(level, prepend=level[:1]), 0.0)
        shift = np.cumsum(moved - np.where(both, went - _usual(stamps), 0.0))
        sets = (stamps + shift)[both | (by_log & (came > MIN_LEAP_S))]
        return Clock(np.maximum.accumulate(arrival), level, shift, tuple(sets.tolist()), found, origin, of_arrival)

    def times_of(self, arrival: Array, stamps: Array | None, ours: bool = False) -> tuple[Array, bool]:
        """The stream's times (n,) [s] on this clock, and whether its own stamps count on it.

        In our own form they always do (`ours`): there the stamps alone are the time. Times go on over a restart of the
        vehicle, by as much as went by on the log's clock.
        """
        arrival = self.origin + (arrival - self.origin) * self.pace
        # the first of those that came at once: where the log's clock falls back, all later ones stand at its highest
        piece = np.searchsorted(self.arrival, arrival)
        piece = piece - (np.append(self.arrival, np.inf)[piece] != arrival)
        piece = np.clip(piece, 0, np.searchsorted(self.arrival, self.arrival[-1]))
        shift, level = self.shift[piece], self.apart[piece]
        if ours and stamps is not None:
            return stamps + shift, True
        by_arrival = arrival - level + shift
        if stamps is not None and np.isfinite(stamps).any():
            # By how many turns of a 32-bit counter the two clocks are apart, message by message.
            apart = arrival - stamps - level
            turns = np.round(apart / WRAP_S)
            behind = apart - turns * WRAP_S
            if float(np.nanmedian(np.abs(behind))) < SAME_CLOCK_S and pace(arrival, stamps) == 1.0:
                real = (behind > -SAME_CLOCK_S) & (behind < MAX_DELAY_S)
                return np.where(real, stamps + turns * WRAP_S + shift, by_arrival), True
        return by_arrival, False


MIN_PACE_APART = 0.02
"""How far a pace is from 1 before it is one [1]: crystals are within 0.0001, and messages that are late make some."""
PACES = (0.02, 50.0)
"""Within which paces a clock is another clock's: beyond, its stamps are in another unit."""
MIN_PACE_SPAN_S = 10.0
"""Time over which a pace is seen [s]."""


def pace(arrival: Array, stamps: Array) -> float:
    """Seconds of stamps (n,) in a second of arrivals (n,), the median over quarters of a log; 1 near it.

    A clock that was set, or messages that were late, are in fewer than half of these quarters.
    """
    known = np.isfinite(arrival) & np.isfinite(stamps)
    arrival, stamps = arrival[known], stamps[known]
    reach = arrival.size // 4
    if reach < 5 or np.ptp(arrival) < MIN_PACE_SPAN_S:
        return 1.0
    came, went = arrival[reach:] - arrival[:-reach], stamps[reach:] - stamps[:-reach]
    if not (came > 0.0).any():
        return 1.0
    found = float(np.median(went[came > 0.0] / came[came > 0.0]))
    return found if abs(found - 1.0) > MIN_PACE_APART and PACES[0] < found < PACES[1] else 1.0


def pace_note(name: str, found: float) -> str:
    """The note on a clock of another speed."""
    return (
        f"the clock of {name} runs at {found:.3g} times the speed of the arrivals, as a simulator's does: what bears "
        "no stamp of it is placed by its arrival at that ratio"
    )


def without_leaps(time: Array) -> tuple[Array, tuple[float, ...]]:
    """Stamps (n,) [s] of one clock that go on where it was set forward, and when that was on them [s]."""
    steps = np.diff(time, prepend=time[:1])
    leaps = steps > MIN_LEAP_S
    gone_on = time - np.cumsum(np.where(leaps, steps - _usual(time), 0.0))
    return gone_on, tuple(gone_on[leaps].tolist())


def set_at(at: float) -> str:
    """The note on a clock that was set [s]."""
    return f"the clock of the log was set at {at:.10g} s: the log continues there"


MAX_SETS = 8
"""The times that the clock of one table is set back at most: more are rows out of order, which sorting mends."""

MIN_SINGLE_SHARE = 0.98
"""Share of a table's different rows that have a stamp of their own where equal ones are the same row."""
MIN_SET_STEPS = 10.0
"""The usual steps by which a clock that was set falls back at least: rows that changed places fall by fewer."""


def table_time(table: Table, field: str) -> tuple[Array, tuple[str, ...]]:
    """The time of a table (n,), in its unit, that goes on where its clock was set back, and whose rows of one instant
    are spread over it where each of them is a sample, NaN in rows that come again; and a note on each.

    A clock that was set back makes the rows fall; where they fall because the messages of one topic follow those of
    another one, no column has values on both sides, and the rows are only out of order.
    """
    others = [values for name, values in table.columns.items() if name != field]
    again = _come_again(table.columns[field], others)
    time = np.where(again, np.nan, table.columns[field])
    time, sets = _continued(time, [np.isfinite(values) for values in others])
    time, at_once = _spread(time, others)
    notes = [set_at(at) for at in sets]
    if again.any():
        notes.insert(0, f"{np.count_nonzero(again)} of {again.size} rows come again with all their values: taken once")
    if at_once > 1:
        notes.append(f"{at_once} rows bear each stamp of {field!r}: they are spread evenly up to the next stamp")
    return time, tuple(notes)


def _come_again(time: Array, others: Sequence[Array]) -> NDArray[np.bool_]:
    """(n,) whether a row was there before, stamp and all, where nearly every stamp has one row but for these.

    Where stamps are coarser than rows, rows at rest are alike, too: then most stamps have several.
    """
    known, again = np.flatnonzero(np.isfinite(time)), np.zeros(time.size, dtype=np.bool_)
    if known.size == np.unique(time[known]).size:
        return again
    rows = np.nan_to_num(np.column_stack([time, *others])[known], nan=np.inf)
    first = np.unique(rows, axis=0, return_index=True)[1]
    if np.unique(time[known][first]).size > MIN_SINGLE_SHARE * first.size:
        again[known] = True
        again[known[first]] = False
    return again


def _continued(time: Array, others: Sequence[NDArray[np.bool_]]) -> tuple[Array, tuple[float, ...]]:
    """A table's time (n,) that goes on where it falls, and when that was; as it is where rows are out of order."""
    known = np.flatnonzero(np.isfinite(time))
    steps = np.diff(time[known])
    rising = steps[steps > 0.0]
    falls = 1 + np.flatnonzero(steps < 0.0)
    if not falls.size or not rising.size or falls.size > MAX_SETS:
        return time, ()
    usual = float(np.median(rising))
    if (steps[falls - 1] > -MIN_SET_STEPS * usual).any():  # rows that changed places
        return time, ()
    parts = [[bool(each[rows].any()) for each in others] for rows in np.split(known, falls)]
    if any(part != parts[0] for part in parts):
        return time, ()
    gone_on = time.copy()
    jumps = np.zeros(known.size)
    jumps[falls] = usual - steps[falls - 1]
    gone_on[known] += np.cumsum(jumps)
    return gone_on, tuple(gone_on[known[falls]].tolist())


def _spread(time: Array, others: Sequence[Array]) -> tuple[Array, int]:
    """The time (n,) of rows that share stamps which are coarser than they, and how many share one; 1 where none do."""
    known = np.flatnonzero(np.isfinite(time))
    if (np.diff(time[known]) > 0.0).all():
        return time, 1
    stamps, first, place, count = np.unique(time[known], return_index=True, return_inverse=True, return_counts=True)
    if stamps.size < 3 or np.median(count) < 2 or (np.diff(time[known]) < 0.0).any():
        return time, 1
    for values in others:
        there = np.isfinite(values[known])
        changes = np.diff(values[known][there]) != 0.0
        inside = np.diff(place[there]) == 0
        if (
            np.count_nonzero(changes & inside) > 0.5 * np.count_nonzero(inside)
            and np.median(np.bincount(place[there], minlength=stamps.size)) >= 2
        ):
            break
    else:  # rows of one instant, one for each topic
        return time, 1
    rows = np.arange(known.size, dtype=np.float64)
    period = float(np.median(np.diff(stamps))) / float(np.median(count))
    spread = np.interp(rows, first, stamps)
    begins, ends = int(first[1]), int(first[-1])  # the first stamp and the last are seen in part
    spread[:begins] = stamps[1] - period * (begins - rows[:begins])
    spread[ends:] = stamps[-1] + period * (rows[ends:] - ends)
    gone_on = time.copy()
    gone_on[known] = spread
    return gone_on, int(np.median(count))


def without_unset(stamps: Array) -> Array:
    """(n,) stamps [s], NaN where a driver set none: zeros that a clock which began at zero would not show."""
    zero, others = stamps == 0.0, np.abs(stamps[np.isfinite(stamps) & (stamps != 0.0)])
    if zero.any() and others.size and (zero.sum() > 1 or float(others.min()) > MIN_APART_FROM_ZERO_S):
        return np.where(zero, np.nan, stamps)
    return stamps


def _jumps(apart: Array) -> NDArray[np.intp]:
    """The messages before which one of the two clocks jumped, for arrivals minus stamps (n,) [s].

    A message that is late shows nothing: some of its neighbours are not. Single wrong stamps show nothing either.
    """
    steady, around = _middle_of_three(apart), 2 * (min(DELAY_MESSAGES, apart.size) // 2)
    before, after = _least(steady, around, 0), _least(steady, 0, around)
    return 1 + np.flatnonzero((np.diff(after) > SAME_CLOCK_S) | (np.diff(before) < -SAME_CLOCK_S))


def _middle_of_three(values: Array) -> Array:
    """(n,) the median of each value and its neighbours."""
    one, two = np.concatenate((values[:1], values[:-1])), np.concatenate((values[1:], values[-1:]))
    return np.asarray(np.maximum(np.minimum(one, values), np.minimum(np.maximum(one, values), two)))


def _least(values: Array, before: int, after: int) -> Array:
    """(n,) the least of each value, so many before it and so many after it; the first and the last value go on.

    A window of the length of a block is the end of one block and the begin of the next (van Herk).
    """
    size, count = before + after + 1, values.size
    padded = np.pad(values, (before, after), mode="edge")
    blocks = np.pad(padded, (0, -padded.size % size), mode="edge").reshape(-1, size)
    begins = np.minimum.accumulate(blocks, axis=1).ravel()
    ends = np.minimum.accumulate(blocks[:, ::-1], axis=1)[:, ::-1].ravel()
    return np.asarray(np.minimum(ends[:count], begins[size - 1 : size - 1 + count]))


def _without_late(begins: NDArray[np.intp], apart: Array, stamps: Array) -> NDArray[np.intp]:
    """The jumps without those after which messages are only late: they repeat stamps, or the way is as before later."""
    kept: list[int] = []
    levels = [float(np.median(piece)) for piece in np.split(apart, begins)]
    now = levels[0]
    for k, (begin, end) in enumerate(pairwise([*begins, apart.size]), start=1):
        if SAME_CLOCK_S < levels[k] - now < MIN_LEAP_S:
            repeated = np.mean(np.isin(stamps[begin:end], stamps[:begin])) > 0.5
            if repeated or any(abs(later - now) < SAME_CLOCK_S for later in levels[k + 1 :]):
                continue
        if abs(levels[k] - now) > SAME_CLOCK_S:
            kept.append(int(begin))
            now = levels[k]
    return np.array(kept, dtype=np.intp)


def _usual(time: Array) -> float:
    """The usual step of stamps (n,) [s]."""
    return float(np.median(np.diff(time))) if time.size > 1 else 0.0


def _level(apart: Array, paced: bool) -> Array:
    """(n,) arrival minus stamp of messages on time: one number, or each its own where paces differ or many are late.

    A simulator's pace wavers (`paced`): its messages on time are the usual ones about each.
    """
    middle = np.median(apart)
    if middle - np.quantile(apart, 0.05) < 0.5 * SAME_CLOCK_S:
        return np.full(apart.size, middle)
    if paced:
        from scipy.ndimage import median_filter  # here and not above: without it, `inspect` and a learner save 15 MB

        return np.asarray(median_filter(apart, size=min(DELAY_MESSAGES, apart.size), mode="nearest"))
    before = DELAY_MESSAGES // 2
    return _least(_middle_of_three(apart), before, DELAY_MESSAGES - before - 1)
