"""The outputs of an autopilot by their numbers, those that bear no pulse, and whether they move."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

import numpy as np

from incsvr.numerics import Array
from service.inputs.owners import base, instance
from service.inputs.settings import Thrusters
from service.inputs.thrust import FULL_PULSE_US, T200_DEAD_BAND_US, is_pulse

BANK_OUTPUTS = 16
"""Outputs in one SERVO_OUTPUT_RAW of MAVLink 2: outputs 17 to 32 are those of the bank (`port`) 1."""
MAVLINK_1_OUTPUTS = 8
"""Outputs after which a message of MAVLink 1 ends."""
_FIELD = re.compile(r"(?:^|\.)(?:servo(\d+)_raw|C(\d+))$")


def output(topic: str, field: str) -> int | None:
    """The number of an output by where its command stands; None where that is no autopilot's output."""
    found = _FIELD.search(field)
    if found is None:
        return None
    bank = instance(topic) if found[1] else ""
    return int(found[1] or found[2]) + (BANK_OUTPUTS * int(bank) if bank.isdecimal() else 0)


def output_numbers(settings: Thrusters) -> tuple[int | None, ...]:
    """The output of each thruster."""
    return tuple(output(topic, each.field) for each, topic in zip(settings.each, settings.topics, strict=True))


def without_pulse(settings: Thrusters, thrusters: Iterable[int]) -> str:
    """The sentence on thrusters, by their places, that never get a pulse; it names their outputs and the cure."""
    silent = list(thrusters)
    places = [output_numbers(settings)[k] for k in silent]
    topic = settings.topics[silent[0]].rpartition("/")[2]
    named = [settings.each[k].field if place is None else str(place) for k, place in zip(silent, places, strict=True)]
    cure = "let them carry one, or name in SERVOn_FUNCTION or inputs.thrusters the outputs that drive the thrusters"
    if base(topic) == "SERVO_OUTPUT_RAW" and any(place is not None and place > MAVLINK_1_OUTPUTS for place in places):
        cure = (
            "MAVLink 1 carries outputs 1 to 8 of a bank alone: set the link to MAVLink 2 (SERIALn_PROTOCOL 2), use "
            "the vehicle's own .BIN, or describe the thrusters in inputs.thrusters if they are on another bank "
            "(topic: SERVO_OUTPUT_RAW[1])"
        )
    several = len(named) > 1
    return (
        f"output{'s' if several else ''} {', '.join(named)} of {topic} drive{'' if several else 's'} the thrusters and "
        f"never carr{'y' if several else 'ies'} a pulse: {cure}"
    )


MIN_PULSE_MOVEMENT_US = max(T200_DEAD_BAND_US)
"""The change beyond which a pulse leaves the dead band of a T200 [µs]; one that trembles at rest does not."""


def least_movement(settings: Thrusters) -> float:
    """The change of a command that counts as movement, in its unit; only pulses have a known band."""
    return {"pwm": MIN_PULSE_MOVEMENT_US, "fraction": MIN_PULSE_MOVEMENT_US / FULL_PULSE_US}.get(settings.command, 0.0)


Ends = tuple[Array, Array]
"""The least and the greatest of each command (k,) until now."""


def movement(commands: Array, least: float, ends: Ends | None) -> tuple[int | None, Ends]:
    """The row of commands (n, k), in the order of their messages, by which one of them has moved; None if none did.

    Args:
        least: the change beyond which a command has moved; with that of pulses only pulses count.
        ends: before; also returned, after these.
    """
    known = np.isfinite(commands)
    if least == MIN_PULSE_MOVEMENT_US:
        known &= is_pulse(commands)
    low, high = np.where(known, commands, np.inf), np.where(known, commands, -np.inf)
    if ends is not None:
        low[0], high[0] = np.minimum(low[0], ends[0]), np.maximum(high[0], ends[1])
    low, high = np.minimum.accumulate(low), np.maximum.accumulate(high)
    moved = (high - low > least).any(axis=1)
    return int(np.argmax(moved)) if moved.any() else None, (low[-1], high[-1])


def first_movement(
    commands: Sequence[Array], least: float, ends: Ends | None = None, at_once: int = 4096
) -> tuple[int | None, Ends | None]:
    """As `movement`, of commands (n,) each, so many messages at once."""
    for begin in range(0, commands[0].size, at_once):
        part = np.stack([command[begin : begin + at_once] for command in commands], axis=1)
        row, ends = movement(part, least, ends)
        if row is not None:
            return begin + row, ends
    return None, ends
