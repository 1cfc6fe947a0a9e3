"""The thrusters of a vehicle with ArduSub: frame, motor directions and outputs, from its parameters."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from math import isfinite
from typing import Any

from service.inputs.arming import MAX_WHOLE_NUMBER
from service.inputs.forms import as_float
from service.inputs.settings import Sign, Thruster
from service.inputs.table import Assumption
from service.inputs.vehicle_kind import MOTOR_FUNCTIONS, output_functions

FRAME_NAMES = {1: "BlueROV2", 2: "BlueROV2 Heavy"}
"""FRAME_CONFIG of the frames whose levers are known: vectored, and vectored with six degrees of freedom."""
YAW_SHARES = (1.0, -1.0, -1.0, 1.0)
"""The share of motors 1 … 4 in a turn clockwise, in ArduSub's table of both frames."""
YAW_ARMS_M = {1: 0.189, 2: 0.171}
"""Moment by thrust about the vertical axis [m]: thrusters at ±(0.156, 0.111) m and 45° (Wu 2018); of the Heavy the mean
of 0.167 and 0.175 m in a published model (von Benzon 2022)."""


def frame(parameters: Mapping[str, float]) -> int | None:
    """The frame that the vehicle says it has."""
    said = parameters.get("FRAME_CONFIG")
    return None if said is None or not isfinite(said) else int(said)


def concerns_thrusters(name: str) -> bool:
    """Whether a parameter of the vehicle has to do with its thrusters."""
    of_outputs = name.startswith(("MOT_", "SERVO")) and name.endswith(("_DIRECTION", "_FUNCTION"))
    return of_outputs or name in ("FRAME_CONFIG", "FRAME_CLASS")


def assumption(parameters: Mapping[str, float]) -> Assumption | None:
    """The assumptions on thrusters whose parameters the vehicle did not send: one sentence with its cure."""
    untold = [f"MOT_{motor}_DIRECTION" for motor in range(1, len(YAW_SHARES) + 1)]
    untold = [name for name in ("FRAME_CONFIG", *untold) if name not in parameters]
    if not untold:
        return None
    taken = "a BlueROV2 (frame 1, T200 thrusters), all " if "FRAME_CONFIG" in untold else ""
    example = ", ".join(f"{name}: {2 if name == 'FRAME_CONFIG' else -1}" for name in untold[:2])
    return Assumption(
        f"the vehicle has not sent {untold[0]}{' and others' * (len(untold) > 1)}: assumed {taken}directions +1; "
        f"if its own are others, give them, as in --set 'inputs.parameters={{{example}}}'"
    )


def thrusters(
    parameters: Mapping[str, float], kind: int, place: Callable[[int], tuple[str, str]]
) -> tuple[Thruster, ...]:
    """The four thrusters of a frame that turn it; positive clockwise seen from above, as MAVLink's yaw rate is.

    Args:
        parameters: of the vehicle, as far as they are known.
        kind: 1 or 2.
        place: topic and path of the command of an output, by its number.
    """
    driven = output_functions(parameters)
    outputs = {driven[output] - MOTOR_FUNCTIONS[0] + 1: output for output in sorted(driven, reverse=True)}
    found = []
    for motor, share in enumerate(YAW_SHARES, start=1):
        direction: Sign = -1 if parameters.get(f"MOT_{motor}_DIRECTION", 1.0) < 0.0 else 1
        topic, field = place(outputs.get(motor, motor))
        found.append(Thruster(topic=topic, field=field, direction=direction, arm=share * YAW_ARMS_M[kind]))
    return tuple(found)


def at_one_topic(each: tuple[Thruster, ...]) -> tuple[str, tuple[Thruster, ...]]:
    """The topic that all thrusters share, and the thrusters without it; no topic where they share none."""
    topics = {thruster.topic for thruster in each}
    if len(topics) > 1:
        return "", each
    return topics.pop(), tuple(thruster.model_copy(update={"topic": ""}) for thruster in each)


MAX_CHANGES_SHOWN = 6
"""Changes that are kept to be shown, the newest."""


class VehicleParameters:
    """The parameters that vehicles have sent.

    Args:
        kept: as `by_system` gave it in an earlier process.

    Attributes:
        by_system: values by name, by vehicle.
    """

    def __init__(self, kept: Mapping[str, Any] | None = None) -> None:
        self.by_system: dict[str, dict[str, float]] = {name: dict(told) for name, told in (kept or {}).items()}
        self._changes: dict[str, deque[str]] = {}

    def of(self, system: str) -> dict[str, float]:
        """The parameters of a vehicle; before one is taken, those of the only one that sent any."""
        if not system and len(self.by_system) == 1:
            (system,) = self.by_system
        return dict(self.by_system.get(system, {}))

    def take(self, system: str, message: Any, when: float) -> bool:
        """Takes a PARAM_VALUE of a vehicle, as JSON, at a time of its clock [s]; True where it changes something.

        Where that time is not known, NaN, the change is not named.
        """
        body = message.get("message") if isinstance(message, dict) else None
        if not isinstance(body, dict):
            return False
        name, value = body.get("param_id"), as_float(body.get("param_value"))
        if isinstance(name, list):
            name = "".join(str(each) for each in name)
        if not isinstance(name, str) or value is None or not abs(value) < MAX_WHOLE_NUMBER:
            return False
        name = name.partition("\0")[0]
        told = self.by_system.setdefault(system, {})
        if not concerns_thrusters(name) or told.get(name) == value:
            return False
        if name in told and isfinite(when):
            changes = self._changes.setdefault(system, deque(maxlen=MAX_CHANGES_SHOWN))
            changes.append(f"{change_words(name, value, told[name])} from {when:.6g} s on")
        told[name] = value
        return True

    def note(self, system: str) -> tuple[str, ...]:
        """The sentence on a vehicle's changed parameters."""
        changes = self._changes.get(system, ())
        return (f"parameters changed during the log, and apply from then on: {', '.join(changes)}",) if changes else ()


def change_words(name: str, value: float, before: float) -> str:
    """A change of a parameter, such as `MOT_1_DIRECTION -1 (1 before)`."""
    return f"{name} {value:g} ({before:g} before)"
