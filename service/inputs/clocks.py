"""One clock for all streams: each stamp where the vehicle's own clock has it, whoever wrote it down and whenever.

A vehicle's messages bear its clock, in different units, some of which run over; others bear none, and only the log's
time of arrival tells when they were. The yaw rate's stamps are the reference: what shares their clock keeps its own
stamps, everything else is placed by its arrival.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from incsvr.samples import Array

WRAP = 2.0**32 * 1e-6
"""A stamp of 32 bits in µs begins anew after so long [s]."""
RESTART = 1.0
"""A clock that falls back by more was set, or the vehicle started anew [s]."""
SAME = 1.0
"""Clocks that differ by less are one clock: the rest is the way of the messages [s]."""
APART_FROM_ZERO = 60.0
"""Where all other stamps are further from zero, a single stamp of zero is none [s]."""


@dataclass(frozen=True, slots=True)
class Clock:
    """The reference: pieces between which the vehicle's clock jumped.

    Attributes:
        since: (m,) arrival of each piece's first message [s], rising.
        offset: (m,) arrival minus stamp in it, the median [s].
    """

    since: Array
    offset: Array

    @staticmethod
    def of(arrival: Array, stamps: Array | None) -> Clock:
        """The clock of a stream (n,) [s]; without stamps the clock is that of arrival."""
        given = np.empty(0, dtype=bool) if stamps is None else np.isfinite(stamps)
        if stamps is None or not given.any():
            return Clock(np.array([-np.inf]), np.zeros(1))
        arrival, stamps = arrival[given], stamps[given]
        begins = np.flatnonzero(np.concatenate(([True], np.diff(stamps) < -RESTART)))
        apart = np.split(arrival - stamps, begins[1:])
        since = arrival[begins]
        since[0] = -np.inf
        return Clock(since, np.array([_median(piece) for piece in apart]))

    def placed(self, arrival: Array, stamps: Array | None, ours: bool = False) -> tuple[Array, bool]:
        """The stream's times (n,) [s] on this clock, and whether its own stamps count on it.

        In our own form they always do (`ours`): there the stamps alone are the time. Times go on over a restart of the
        vehicle, by as much as went by on the log's clock.
        """
        piece = np.clip(np.searchsorted(self.since, arrival, side="right") - 1, 0, None)
        shift = self.offset[piece] - self.offset[0]
        if ours and stamps is not None:
            return stamps + shift, True
        if stamps is not None and np.isfinite(stamps).any():
            # By how many turns of a 32-bit counter the two clocks are apart, message by message.
            apart = arrival - stamps - self.offset[piece]
            turns = np.round(apart / WRAP)
            if float(np.nanmedian(np.abs(apart - turns * WRAP))) < SAME:
                own = stamps + turns * WRAP + shift
                return np.where(np.isnan(own), arrival - self.offset[0], own), True
        return arrival - self.offset[0], False


def without_unset(stamps: Array) -> Array:
    """(n,) stamps [s], NaN where a driver set none: zeros that a clock which began at zero would not show."""
    zero, others = stamps == 0.0, np.abs(stamps[np.isfinite(stamps) & (stamps != 0.0)])
    if zero.any() and others.size and (zero.sum() > 1 or float(others.min()) > APART_FROM_ZERO):
        return np.where(zero, np.nan, stamps)
    return stamps


def _median(apart: Array) -> float:
    """Of the known ones; zero where none is, for then nothing is placed by it."""
    known = apart[np.isfinite(apart)]
    return float(np.median(known)) if known.size else 0.0
