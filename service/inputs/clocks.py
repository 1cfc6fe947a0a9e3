"""One clock for all streams: each stamp where the vehicle's own clock has it, whoever wrote it down and whenever.

A vehicle's messages bear its clock, in different units, some of which run over; others bear none, and only the log's
time of arrival tells when they were. The yaw rate's stamps are the reference: what shares their clock keeps its own
stamps, everything else is placed by its arrival. Both clocks may be set under way, and the vehicle may start anew.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter, minimum_filter1d

from incsvr.numerics import Array

WRAP = 2.0**32 * 1e-6
"""A stamp of 32 bits in µs begins anew after so long [s]."""
SAME = 1.0
"""Clocks that differ by less are one clock: the rest is the way of the messages [s]."""
APART_FROM_ZERO = 60.0
"""Where all other stamps are further from zero, a single stamp of zero is none [s]."""
LATEST = 60.0
"""A message that comes so long after its stamp bears a wrong one [s]."""
LEAP = 86_400.0
"""A pause of a day within one log is none: the clock was set, as by GPS after a start in 1970 [s]."""
AROUND = 21
"""Messages by which the way from stamp to arrival is judged: some of them come on time, also over a second link."""


@dataclass(frozen=True, slots=True)
class Clock:
    """The reference, message by message.

    Attributes:
        arrival: (m,) when its messages arrived [s], not falling.
        apart: (m,) arrival minus stamp of a message that is on time [s].
        shift: (m,) what makes one time that goes on of the stamps [s].
        sets: when the log's clock was set, on that time [s].
    """

    arrival: Array
    apart: Array
    shift: Array
    sets: tuple[float, ...] = ()

    @staticmethod
    def of(arrival: Array, stamps: Array | None) -> Clock:
        """The clock of a stream (n,) [s]; without stamps the clock is that of arrival."""
        given = np.isfinite(arrival) if stamps is None else np.isfinite(arrival) & np.isfinite(stamps)
        if stamps is not None and not given.any():
            return Clock.of(arrival, None)
        arrival = arrival[given]
        stamps = arrival if stamps is None else stamps[given]
        if not arrival.size:
            return Clock(np.zeros(1), np.zeros(1), np.zeros(1))
        apart = arrival - stamps
        begins = _without_late(_jumps(apart), apart, stamps)
        level = np.concatenate([_level(piece) for piece in np.split(apart, begins)])
        jumps = np.isin(np.arange(apart.size), begins)
        came, went = np.diff(arrival, prepend=arrival[:1]), np.diff(stamps, prepend=stamps[:1])
        by_log = jumps & ((came > LEAP) | (came < -SAME))
        both = (came > LEAP) & (went > LEAP)
        moved = np.where(jumps & ~by_log, np.diff(level, prepend=level[:1]), 0.0)
        shift = np.cumsum(moved - np.where(both, went - _usual(stamps), 0.0))
        sets = (stamps + shift)[both | (by_log & (came > LEAP))]
        return Clock(np.maximum.accumulate(arrival), level, shift, tuple(sets.tolist()))

    def placed(self, arrival: Array, stamps: Array | None, ours: bool = False) -> tuple[Array, bool]:
        """The stream's times (n,) [s] on this clock, and whether its own stamps count on it.

        In our own form they always do (`ours`): there the stamps alone are the time. Times go on over a restart of the
        vehicle, by as much as went by on the log's clock.
        """
        piece = np.clip(np.searchsorted(self.arrival, arrival, side="right") - 1, 0, None)
        shift, level = self.shift[piece], self.apart[piece]
        if ours and stamps is not None:
            return stamps + shift, True
        by_arrival = arrival - level + shift
        if stamps is not None and np.isfinite(stamps).any():
            # By how many turns of a 32-bit counter the two clocks are apart, message by message.
            apart = arrival - stamps - level
            turns = np.round(apart / WRAP)
            behind = apart - turns * WRAP
            if float(np.nanmedian(np.abs(behind))) < SAME:
                real = (behind > -SAME) & (behind < LATEST)
                return np.where(real, stamps + turns * WRAP + shift, by_arrival), True
        return by_arrival, False


def going_on(time: Array) -> tuple[Array, tuple[float, ...]]:
    """Stamps (n,) [s] of one clock that go on where it was set forward, and when that was on them [s]."""
    steps = np.diff(time, prepend=time[:1])
    leaps = steps > LEAP
    gone_on = time - np.cumsum(np.where(leaps, steps - _usual(time), 0.0))
    return gone_on, tuple(gone_on[leaps].tolist())


def set_at(at: float) -> str:
    """What is said of a clock that was set [s]."""
    return f"the clock of the log was set at {at:.6g} s: the log goes on there"


def without_unset(stamps: Array) -> Array:
    """(n,) stamps [s], NaN where a driver set none: zeros that a clock which began at zero would not show."""
    zero, others = stamps == 0.0, np.abs(stamps[np.isfinite(stamps) & (stamps != 0.0)])
    if zero.any() and others.size and (zero.sum() > 1 or float(others.min()) > APART_FROM_ZERO):
        return np.where(zero, np.nan, stamps)
    return stamps


def _jumps(apart: Array) -> NDArray[np.intp]:
    """The messages before which one of the two clocks jumped, for arrivals minus stamps (n,) [s].

    A message that is late shows nothing: some of its neighbours are not. Single wrong stamps show nothing either.
    """
    steady = median_filter(apart, size=min(3, apart.size), mode="nearest")
    half = min(AROUND, apart.size) // 2
    size = 2 * half + 1
    before = minimum_filter1d(steady, size, origin=half, mode="nearest")
    after = minimum_filter1d(steady, size, origin=-half, mode="nearest")
    return 1 + np.flatnonzero((np.diff(after) > SAME) | (np.diff(before) < -SAME))


def _without_late(begins: NDArray[np.intp], apart: Array, stamps: Array) -> NDArray[np.intp]:
    """The jumps without those after which messages are only late: they repeat stamps, or the way is as before later."""
    kept: list[int] = []
    levels = [float(np.median(piece)) for piece in np.split(apart, begins)]
    now = levels[0]
    for k, (begin, end) in enumerate(pairwise([*begins, apart.size]), start=1):
        if levels[k] - now > SAME:
            repeated = np.mean(np.isin(stamps[begin:end], stamps[:begin])) > 0.5
            if repeated or any(abs(later - now) < SAME for later in levels[k + 1 :]):
                continue
        if abs(levels[k] - now) > SAME:
            kept.append(int(begin))
            now = levels[k]
    return np.array(kept, dtype=np.intp)


def _usual(time: Array) -> float:
    """The usual step of stamps (n,) [s]."""
    return float(np.median(np.diff(time))) if time.size > 1 else 0.0


def _level(apart: Array) -> Array:
    """(n,) arrival minus stamp of messages on time: one number, or each its own where paces differ or many are late."""
    middle = np.median(apart)
    if middle - np.quantile(apart, 0.05) < 0.5 * SAME:
        return np.full(apart.size, middle)
    return minimum_filter1d(median_filter(apart, size=min(3, apart.size), mode="nearest"), AROUND, mode="nearest")
