"""What several thrusters are told, as one table: each command holds until the next one of the same thruster."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from incsvr.samples import Array
from service.inputs.thrust import is_pulse


@dataclass(frozen=True, slots=True)
class Told:
    """What one thruster is told: times (n,) [s], times of arrival (n,) [s], and commands (n,) in their unit."""

    time: Array
    arrival: Array
    command: Array


def joined(thrusters: Sequence[Told]) -> tuple[Array, Array, list[Array]]:
    """Times (n,) [s] at which one of the thrusters is told something, each once, when the last word of each arrived
    (n,) [s], and what each thruster was told by then, k times (n,); NaN before its first command."""
    time = np.unique(np.concatenate([told.time for told in thrusters]))
    time = time[np.isfinite(time)]
    arrival = np.full(time.size, -np.inf)
    commands = []
    for told in thrusters:
        order = np.argsort(told.time, kind="stable")
        place = np.searchsorted(told.time[order], time, side="right") - 1
        there = order[np.maximum(place, 0)] if order.size else np.zeros(time.size, dtype=np.int64)
        known = (place >= 0) & (order.size > 0)
        commands.append(np.where(known, told.command[there] if order.size else np.nan, np.nan))
        same = known & (told.time[there] == time) if order.size else known
        arrival[same] = np.maximum(arrival[same], told.arrival[there[same]])
    return time, arrival, commands


def held(arrival: Array, stream_arrival: Array, values: Array, before: float = np.nan) -> Array:
    """The newest value (m,) that had arrived at the times `arrival` (n,) [s], and `before` where none had."""
    order = np.argsort(stream_arrival, kind="stable")
    place = np.searchsorted(stream_arrival[order], arrival, side="right") - 1
    if not order.size:
        return np.full(arrival.size, before)
    return np.where(place >= 0, values[order][np.maximum(place, 0)], before)


def since_first_pulse(command: Array) -> Array:
    """The pulses (n,) [µs] from the first one on; NaN before it, for until then the output tells nothing."""
    begun = np.maximum.accumulate(is_pulse(command)) if command.size else np.zeros(0, dtype=bool)
    return np.where(begun, command, np.nan)
