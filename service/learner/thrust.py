"""Thrust that is lost, or back: looked for in the raw data of one learner while they come.

Measurements are pushed from any thread; the thread that learns advances. A look is due every WATCH_PERIOD_S of the
vehicle's time, with the data until then: so the data decide what is found, and not how quickly they are played.
"""

from __future__ import annotations

import logging
import math
import threading
from array import array
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from incsvr.forecasting.command_cells import CommandCells
from incsvr.forecasting.thrust_watch import MEMORY_S, WATCH_PERIOD_S, ThrustChange, ThrustState, look
from incsvr.numerics import Array
from incsvr.signals import TORQUE, YAW_RATE, SignalSettings

log = logging.getLogger(__name__)

SETTLING_S = 1.0
"""Time after a look's end for which its data are waited for, beside the filter's reach [s]."""
MAX_BEHIND_S = MEMORY_S
"""Data that are made up for at most [s], where they come more quickly than they are looked at."""
CAPACITY_VALUES = 200_000
"""Values of a stream that wait at most."""
MAX_AHEAD_S = 30.0
"""How far a stamp may lie from those around it [s]: beyond, it is a mistake, or of another clock."""


class ThrustWatch:
    """The watch of a learner with these signals; `memory` is what an earlier `to_dict` gave."""

    def __init__(self, signals: SignalSettings, memory: Mapping[str, Any] | None = None) -> None:
        self._signals, self._lock = signals, threading.Lock()
        self._raw = {stream: (array("d"), array("d")) for stream in (YAW_RATE, TORQUE)}
        self._cells = CommandCells.none()
        self._looked = -math.inf
        self._wait = signals.widest_reach + signals.lateness + SETTLING_S
        self.state = ThrustState() if memory is None else ThrustState(memory["level"], noise=tuple(memory["noise"]))
        self._found: list[ThrustChange] = []

    def push(self, stream: str, t: Array, value: Array) -> bool:
        """Takes (n,) stamps [s] and values of yaw rate or torque; True where a look is due."""
        if stream not in self._raw:
            return False
        with self._lock:
            for kept, new in zip(self._raw[stream], (t, value), strict=True):
                kept.extend(new.tolist())
                del kept[: max(len(kept) - CAPACITY_VALUES, 0)]
        return self.due > self._looked

    @property
    def due(self) -> float:
        """The end of the last look that the data suffice for [s]; −∞ before both streams have come."""
        last = [sorted(stamps[-3:]) for stamps, _ in self._raw.values()]
        newest = min(stamps[1] if len(stamps) == 3 else -math.inf for stamps in last)  # one stamp may be a mistake
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
            self._cells, self._looked = CommandCells.none(), until
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
        """Makes cells of the raw data until a time [s], and drops these but for what the next cell begins with."""
        with self._lock:
            raw = {name: tuple(np.array(kept) for kept in columns) for name, columns in self._raw.items()}
        streams = {name: self._sound(name, *columns) for name, columns in raw.items()}
        after = float(self._cells.end[-1]) if len(self._cells) else -math.inf
        new = CommandCells.of(streams[YAW_RATE], streams[TORQUE], max(after, end - MAX_BEHIND_S), end, held=True)
        done = float(new.end[-1]) if len(new) else max(after, end - MAX_BEHIND_S)
        self._cells = self._cells.followed_by(new if believed else CommandCells.none(), end - MEMORY_S)
        with self._lock:
            for stamps, values in self._raw.values():
                old = max(int(np.searchsorted(np.maximum.accumulate(np.array(stamps)), done)) - 3, 0)
                del stamps[:old], values[:old]

    def _sound(self, stream: str, stamps: Array, values: Array) -> tuple[Array, Array]:
        """What of a stream is a measurement, by rising stamps, each once."""
        limit = self._signals.rate_limit if stream == YAW_RATE else self._signals.torque_limit
        kept = np.isfinite(stamps) & np.isfinite(values) & (np.abs(values) <= limit)
        stamps, values = stamps[kept], values[kept]
        recent = float(np.median(stamps[-11:])) if stamps.size else 0.0
        near = np.abs(stamps - recent) <= MAX_AHEAD_S + MAX_BEHIND_S
        unique, first = np.unique(stamps[near], return_index=True)
        return unique, values[near][first]
