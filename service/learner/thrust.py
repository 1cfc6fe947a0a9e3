"""Thrust that is lost, or back: looked for in the raw data of one learner while they come.

The thread that learns advances. A look is due every WATCH_PERIOD_S of the
vehicle's time, with the data until then: so the data decide what is found, and not how quickly they are played.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from incsvr.forecasting.command_cells import CommandCells
from incsvr.forecasting.thrust_watch import MEMORY_S, WATCH_PERIOD_S, ThrustChange, ThrustState, look
from incsvr.numerics import Stream
from incsvr.signals import TORQUE, YAW_RATE, SignalSettings
from service.learner.raw_streams import RawStreams

log = logging.getLogger(__name__)

SETTLING_S = 1.0
"""Time after a look's end for which its data are waited for, beside the filter's reach [s]."""
MAX_BEHIND_S = MEMORY_S
"""Data that are made up for at most [s], where they come more quickly than they are looked at."""
MAX_AHEAD_S = 30.0
"""How far a stamp may lie from those around it [s]: beyond, it is a mistake, or of another clock."""


class ThrustWatch:
    """The watch over the raw data of a learner with these signals; `memory` is what an earlier `to_dict` gave."""

    def __init__(self, signals: SignalSettings, raw: RawStreams, memory: Mapping[str, Any] | None = None) -> None:
        self._raw = raw
        self._cells = CommandCells.none()
        self._looked = self._taken = -math.inf  # until when was looked at [s], and until when cells were made
        self._wait = signals.widest_reach + signals.lateness + SETTLING_S
        self.state = ThrustState() if memory is None else ThrustState(memory["level"], noise=tuple(memory["noise"]))
        self._found: list[ThrustChange] = []

    @property
    def is_due(self) -> bool:
        """Whether the data suffice for another look."""
        return self.due > self._looked

    @property
    def due(self) -> float:
        """The end of the last look that the data suffice for [s]; −∞ before both streams have come."""
        newest = min(self._raw.until(stream) for stream in (YAW_RATE, TORQUE))
        if not math.isfinite(newest):
            return -math.inf
        return math.floor((newest - self._wait) / WATCH_PERIOD_S) * WATCH_PERIOD_S

    def advance(self, until: float, inertia: float, believed: bool) -> None:
        """Looks as often as is due until a time [s]; `take` gives what was found.

        Args:
            until: as `due` was, or an earlier time.
            inertia: I in force [kg m²].
            believed: whether the streams are; else they are passed over.
        """
        if until < self._looked - MAX_AHEAD_S and math.isfinite(until):  # the clocks began anew
            self._cells, self._looked, self._taken = CommandCells.none(), until, -math.inf
            self.state = replace(self.state, since=-math.inf, fitted=-math.inf)
        if not math.isfinite(until):
            return
        last = math.floor(until / WATCH_PERIOD_S)
        first = last - int(MAX_BEHIND_S / WATCH_PERIOD_S)
        if math.isfinite(self._looked):
            first = max(first, round(self._looked / WATCH_PERIOD_S) + 1)
        for end in (WATCH_PERIOD_S * number for number in range(first, last + 1)):
            self._take_in(end, believed)
            self._looked = end
            if believed and len(self._cells):
                try:
                    self._look(inertia)
                except Exception:  # whatever came, learning goes on; what is usual is told anew
                    log.exception("a fault of this program: the thrust could not be watched")
                    self._cells, self.state = CommandCells.none(), ThrustState(self.state.level)

    def take(self) -> list[ThrustChange]:
        """What was found since this was asked last."""
        found, self._found = self._found, []
        return found

    def _look(self, inertia: float) -> None:
        self.state, change = look(self.state, self._cells, inertia)
        if change is not None:
            self._found.append(change)

    def to_dict(self) -> dict[str, Any]:
        """What must survive a restart, as plain data; the cells come anew."""
        return {"level": self.state.level, "noise": list(self.state.noise)}

    def _take_in(self, end: float, believed: bool) -> None:
        """Makes cells of the raw data until a time [s]."""
        begin = max(self._taken, end - MAX_BEHIND_S)
        rate, torque = (self._after(stream, begin) for stream in (YAW_RATE, TORQUE))
        new = CommandCells.of(rate, torque, begin, end, held=True)
        self._taken = float(new.end[-1]) if len(new) else begin
        self._cells = self._cells.followed_by(new if believed else CommandCells.none(), end - MEMORY_S)

    def _after(self, stream: str, begin: float) -> Stream:
        """The measurements of a stream after a time [s], and those with which the first cell begins."""
        t, value = self._raw.read(stream, MAX_AHEAD_S + MAX_BEHIND_S)
        first = max(int(np.searchsorted(t, begin)) - 3, 0)
        return t[first:], value[first:]
