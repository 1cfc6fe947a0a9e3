"""The outputs of an autopilot by their numbers, and what is said of those that bear no pulse."""

from __future__ import annotations

import re
from collections.abc import Iterable

from service.inputs.instances import base, instance
from service.inputs.settings import Thrusters

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
