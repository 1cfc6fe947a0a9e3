"""The outputs of an autopilot by their numbers, those that bear no pulse, and whether they move."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from math import isfinite

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


class Movement:
    """Message by message: whether one of the commands has changed by more than it does at rest."""

    def __init__(self) -> None:
        self.has_moved = False
        self._ends: dict[str, tuple[float, float]] = {}

    def take(self, commands: Mapping[str, float | None], least: float) -> None:
        """Takes the commands of a message by their paths; those that are pulses count where there is a pulse."""
        for path, command in commands.items():
            if command is None or not isfinite(command) or (least == MIN_PULSE_MOVEMENT_US and not is_pulse(command)):
                continue
            low, high = self._ends.get(path, (command, command))
            self._ends[path] = min(low, command), max(high, command)
            self.has_moved = self.has_moved or max(high, command) - min(low, command) > least


def least_movement(settings: Thrusters) -> float:
    """The change of a command that counts as movement, in its unit; only pulses have a known band."""
    return {"pwm": MIN_PULSE_MOVEMENT_US, "fraction": MIN_PULSE_MOVEMENT_US / FULL_PULSE_US}.get(settings.command, 0.0)


def first_movement(
    commands: Sequence[Array], least: float, ends: Sequence[tuple[float, float]]
) -> tuple[int | None, list[tuple[float, float]]]:
    """The place of the first message by which one of the commands (n,), in their order, has moved; None if none did.

    Args:
        ends: the least and the greatest of each command before; also returned, after these.
    """
    moved, found = np.zeros(commands[0].size, dtype=bool), []
    for command, (least_before, greatest_before) in zip(commands, ends, strict=True):
        known = np.isfinite(command) & (is_pulse(command) if least == MIN_PULSE_MOVEMENT_US else True)
        low = np.minimum.accumulate(np.where(known, command, np.inf)).clip(max=least_before)
        high = np.maximum.accumulate(np.where(known, command, -np.inf)).clip(min=greatest_before)
        moved |= high - low > least
        found.append((float(low[-1]), float(high[-1])) if command.size else (least_before, greatest_before))
    return int(np.argmax(moved)) if moved.any() else None, found
