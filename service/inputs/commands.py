"""The commands of several thrusters on one time axis: each command stays until the next one of its thruster."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from incsvr.numerics import Array
from service.inputs.thrust import is_pulse


@dataclass(frozen=True, slots=True)
class CommandStream:
    """The commands of one thruster.

    Attributes:
        time: (n,) stamps [s], n ≥ 1, in any order.
        arrival: (n,) when each arrived [s].
        command: (n,) in the thruster's unit.
    """

    time: Array
    arrival: Array
    command: Array


def join_commands(streams: Sequence[CommandStream]) -> tuple[Array, Array, list[Array]]:
    """The commands of all thrusters, at each stamp of one of them.

    Returns:
        The stamps (n,) [s], rising, each once; when the last command of each stamp arrived (n,) [s]; the command of
        each thruster at that time, (n,) each, NaN before its first.
    """
    time = np.unique(np.concatenate([stream.time for stream in streams]))
    time = time[np.isfinite(time)]
    arrival = np.full(time.size, -np.inf)
    commands = []
    for stream in streams:
        order = np.argsort(stream.time, kind="stable")
        place = np.searchsorted(stream.time[order], time, side="right") - 1
        newest = order[np.maximum(place, 0)]
        commands.append(np.where(place >= 0, stream.command[newest], np.nan))
        own = (place >= 0) & (stream.time[newest] == time)
        arrival[own] = np.maximum(arrival[own], stream.arrival[newest[own]])
    return time, arrival, commands


def newest_at(arrival: Array, stream_arrival: Array, values: Array, before: float = np.nan) -> Array:
    """The newest of the values (m,) that had arrived at the times `arrival` (n,) [s]; `before` where none had."""
    if not values.size:
        return np.full(arrival.size, before)
    order = np.argsort(stream_arrival, kind="stable")
    place = np.searchsorted(stream_arrival[order], arrival, side="right") - 1
    return np.where(place >= 0, values[order][np.maximum(place, 0)], before)


def since_first_pulse(command: Array) -> Array:
    """The commands (n,) [µs] of an output from its first pulse on; NaN before it, where the output is not in use."""
    return np.where(np.maximum.accumulate(is_pulse(command)), command, np.nan)
