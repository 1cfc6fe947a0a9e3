"""The kind of a vehicle: one that is no ArduSub has other levers than a BlueROV2.

It says so by its heartbeat (MAV_TYPE, MAV_AUTOPILOT), by the name of its firmware, or by what its outputs do.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import isfinite, nan

SUBMARINE, ARDUPILOT = 12, 3
"""MAV_TYPE and MAV_AUTOPILOT of ArduSub."""
_UNSAID = (0, 8)
"""MAV_TYPE_GENERIC, MAV_AUTOPILOT_GENERIC and MAV_AUTOPILOT_INVALID, which say nothing of the vehicle."""
_TYPES = {1: "fixed wing", 2: "quadrotor", 4: "helicopter", 10: "ground rover", 11: "surface boat", 13: "hexarotor"}
_AUTOPILOTS = {4: "openpilot", 12: "px4"}
_NAMES = {"submarine": SUBMARINE, "generic": 0, "ardupilotmega": ARDUPILOT, "invalid": 8}
_ENUMERATED = re.compile(r"^MAV_(?:TYPE|AUTOPILOT)_")
_FIRMWARE = re.compile(r"^(ArduRover|ArduCopter|ArduPlane|AntennaTracker|Blimp|APM:\w+|APMrover2)\b")
BUILD_NAMES = {1: "ArduRover", 2: "ArduCopter", 3: "ArduPlane", 4: "AntennaTracker", 12: "Blimp", 13: "Heli"}
"""The firmware by the number that DataFlash logs have of it (VER.BU)."""
LEFT_THROTTLE, RIGHT_THROTTLE = 73, 74
"""SERVOn_FUNCTION of a vehicle that is steered by two throttles."""
_FUNCTIONS = {LEFT_THROTTLE: "left throttle", RIGHT_THROTTLE: "right throttle", 70: "throttle", 26: "ground steering"}
MOTOR_FUNCTIONS = range(33, 41)
"""SERVOn_FUNCTION of the outputs that drive motors 1 … 8."""
MAX_OUTPUTS = 32
"""Outputs of an autopilot."""


@dataclass(frozen=True, slots=True)
class SelfDescription:
    """A vehicle's description of itself.

    Attributes:
        heartbeat: numbers and texts of a heartbeat of its autopilot, by their paths.
        firmware: the name that its firmware gives itself, empty where it gave none.
    """

    heartbeat: Mapping[str, float | str] = field(default_factory=dict)
    firmware: str = ""


def output_functions(parameters: Mapping[str, float]) -> dict[int, int]:
    """SERVOn_FUNCTION by the number of the output, as far as the parameters have it."""
    values = ((output, parameters.get(f"SERVO{output}_FUNCTION", nan)) for output in range(1, MAX_OUTPUTS + 1))
    return {output: int(function) for output, function in values if isfinite(function)}


def evidence_of_another_vehicle(vehicle: SelfDescription, parameters: Mapping[str, float]) -> str | None:
    """The sign that a vehicle is no ArduSub, in a few words; None without one."""
    evidence = []
    for what, paths, of_ardusub, names in (
        ("type", ("mavtype.type", "mavtype", "type"), SUBMARINE, _TYPES),
        ("autopilot", ("autopilot.type", "autopilot"), ARDUPILOT, _AUTOPILOTS),
    ):
        value = _enumerated(vehicle.heartbeat, paths)
        if value is not None and value not in (of_ardusub, *_UNSAID):
            evidence.append(
                f"its heartbeat reports {what} {names.get(value, value) if isinstance(value, int) else value}"
            )
    firmware = _FIRMWARE.match(vehicle.firmware)
    if firmware:
        evidence.append(f"its firmware is {firmware[1]}")
    if "FRAME_CLASS" in parameters and "FRAME_CONFIG" not in parameters:
        evidence.append("it has FRAME_CLASS and no FRAME_CONFIG")
    outputs = output_functions(parameters)
    if not set(outputs.values()) & set(MOTOR_FUNCTIONS):
        others = [
            f"SERVO{output}_FUNCTION {function} ({_FUNCTIONS[function]})"
            for output, function in outputs.items()
            if function in _FUNCTIONS
        ]
        undriven = ["no SERVOn_FUNCTION is a motor"] if {1, 2, 3, 4} <= outputs.keys() else []
        evidence += others or undriven
    return ", ".join(evidence) or None


def thruster_example(parameters: Mapping[str, float], place: Callable[[int], tuple[str, str]]) -> str:
    """A sentence that asks for the thrusters of a vehicle, with an example for its own outputs.

    Args:
        place: topic and path of an output.
    """
    outputs = output_functions(parameters)
    left, right = (
        next((each for each in outputs if outputs[each] == side), None) for side in (LEFT_THROTTLE, RIGHT_THROTTLE)
    )
    (topic, port), (_, starboard) = place(left or 1), place(right or 3)
    each = f"{{field: {port}, arm: 0.3}}, {{field: {starboard}, arm: -0.3}}"
    return (
        "describe them in a configuration (--config FILE), with its own levers [m] and full thrust [N], as in "
        f"inputs: {{thrusters: {{topic: {topic}, command: pwm, curve: linear, full: 50, each: [{each}]}}}}"
    )


def _enumerated(heartbeat: Mapping[str, float | str], names: tuple[str, ...]) -> int | str | None:
    """A value of an enumeration: its number where that is known, else its name in small letters."""
    for name in names:
        value = heartbeat.get(name, heartbeat.get(f"message.{name}"))
        if isinstance(value, float) and value == value:
            return int(value)
        if isinstance(value, str) and _ENUMERATED.match(value):
            spelt = _ENUMERATED.sub("", value).lower()
            return _NAMES.get(spelt, spelt.replace("_", " "))
    return None
