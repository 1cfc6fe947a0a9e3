"""The thrusters of a vehicle with ArduSub: frame, motor directions and outputs, from its parameters and messages."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from math import isfinite

from service.inputs.outputs import BANK_OUTPUTS, output_numbers
from service.inputs.owners import autopilot_message, base, instance_place, numbered
from service.inputs.proposal import Observation, others_note
from service.inputs.settings import Sign, Source, StampedBy, Thruster, Thrusters
from service.inputs.table import Assumption, Topic
from service.inputs.vehicle_kind import (
    MOTOR_FUNCTIONS,
    evidence_of_another_vehicle,
    output_functions,
    thruster_example,
)

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


Place = Callable[[int], tuple[str, str]]
"""Topic and path of an output, by its number."""
_LOGGED = ("RCOU", "RCO2", "RCO3")
"""The messages of DataFlash that hold outputs: 1 to 14, and where there are more 15 to 18 and 19 to 32."""


def thrusters_by_outputs(
    observed: Observation, voltage: Source | None, message: str
) -> tuple[Thrusters | None, tuple[str, ...], dict[str, str]]:
    """The thrusters by an autopilot's outputs, what is to be said of them, and what is missing where there are none.

    Args:
        voltage: where the battery's stands.
        message: that holds the outputs, SERVO_OUTPUT_RAW of a link or RCOU of a DataFlash log.
    """
    if message in _LOGGED:
        banks = {topic.name: topic for topic in observed.topics if topic.name in _LOGGED}
        cure = "no RCOU was found: let the vehicle log its outputs (bit 10 of LOG_BITMASK)"
    else:
        said = {autopilot_message(topic) or "": topic for topic in sorted(observed.topics, key=lambda each: each.count)}
        banks = {name: said[name] for name in sorted(said, key=instance_place) if base(name) == message}
        cure = f"no {message} was found: let the vehicle send it (SR*_RC_CHAN), or use the vehicle's own .BIN"
    if not banks:
        return None, (), {"torque": cure}
    first = next(iter(banks.values()))
    whole, path = base(first.name), "message." if any(name.startswith("message.") for name in first.fields) else ""
    place: Place = partial(_logged, banks) if message in _LOGGED else partial(_sent, whole, path)
    kind, notes, missing = _frame_of(observed, place if message in _LOGGED else partial(_sent, message, ""))
    if kind is None:
        return None, notes, missing
    topic, each = at_one_topic(thrusters(observed.parameters, kind, place))
    clock = StampedBy(stamp="TimeUS" if message in _LOGGED else f"{path}time_usec", stamp_unit="us")
    found = Thrusters(topic=topic, command="pwm", each=each, measured_voltage=voltage, **clock)
    used = list(dict.fromkeys(found.topics))
    left = [] if message in _LOGGED else [name for name, bank in banks.items() if bank.name not in used]
    taken = ", ".join(message + name.removeprefix(whole) for name in used)
    why = f"where outputs {', '.join(map(str, output_numbers(found)))} are"
    return found, (*notes, *others_note("torque", taken, left, why, "inputs.thrusters names another")), {}


def _sent(topic: str, path: str, output: int) -> tuple[str, str]:
    """Topic and path of an output on a link: sixteen in each instance of the message."""
    bank, place = divmod(output - 1, BANK_OUTPUTS)
    return numbered(topic, bank), f"{path}servo{place + 1}_raw"


def _logged(banks: Mapping[str, Topic], output: int) -> tuple[str, str]:
    """Message and field of an output in a DataFlash log; the first message where none has it."""
    field = f"C{output}"
    return next((name for name in _LOGGED if name in banks and field in banks[name].fields), _LOGGED[0]), field


def _frame_of(observed: Observation, place: Place) -> tuple[int | None, tuple[str, ...], dict[str, str]]:
    """The frame by the vehicle's own parameters, what is to be said of it, and what is missing where none is known.

    Args:
        place: topic and path of an output, as people write them in a configuration.
    """
    other = evidence_of_another_vehicle(observed.self_description, observed.parameters)
    if other is not None:
        cure = thruster_example(observed.parameters, place)
        return (
            None,
            (),
            {
                "torque": f"the thrusters' places and directions are unknown, because this is no "
                f"BlueROV2 ({other}): {cure}"
            },
        )
    kind = frame(observed.parameters)
    doubt = assumption(observed.parameters)
    assumed = () if doubt is None else (doubt,)
    if kind is None:
        return 1, assumed, {}
    if kind not in FRAME_NAMES:
        cure = f"the levers of frame {kind} are not known: {thruster_example(observed.parameters, place)}"
        return None, (), {"torque": cure}
    names = [f"MOT_{motor}_DIRECTION" for motor in range(1, len(YAW_SHARES) + 1)]
    told = [f"{observed.parameters[name]:+.0f}" for name in names if name in observed.parameters]
    directions = f", directions {', '.join(told)}" if told else ""
    by = f"frame {kind} ({FRAME_NAMES[kind]}){directions}, by the vehicle's parameters"
    return kind, (by, *assumed), {}
