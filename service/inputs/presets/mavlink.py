"""MAVLink as it is on a link: telemetry logs, and the JSON of BlueOS's Zenoh router and recorder.

MAVLink's axes are north, east, down: yaw counts clockwise seen from above, and so does the moment that is made of
ArduSub's outputs.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from service.inputs import frames
from service.inputs.presets.proposal import Observed, Proposal
from service.inputs.settings import Armed, Inputs, Source, StampedBy, Thrusters
from service.logs.table import Topic

_KEY = re.compile(r"(?:^|.*/)mavlink/(\d+)/(\d+)/([A-Z0-9_]+)$")
MESSAGES = (
    "ATTITUDE",
    "SERVO_OUTPUT_RAW",
    "HEARTBEAT",
    "VFR_HUD",
    "BATTERY_STATUS",
    "SYS_STATUS",
    "PARAM_VALUE",
)
"""What is listened to on a bus."""
AUTOPILOT = 1
"""The component that flies."""
ARMED = 128
"""The bit of a heartbeat's base mode that says that the autopilot is armed (MAV_MODE_FLAG_SAFETY_ARMED)."""


def proposal(observed: Observed) -> Proposal | None:
    """The mapping of a vehicle that speaks MAVLink; None where there is no attitude of an autopilot."""
    said = {message: (topic, path) for message, topic, path in _messages(observed)}
    if "ATTITUDE" not in said:
        return None
    topic, path = said["ATTITUDE"]
    clock = StampedBy(stamp=f"{path}time_boot_ms", stamp_unit="ms")
    channels = {
        name: Source(topic=topic.name, field=f"{path}{field}", unit=unit, **clock)
        for name, field, unit in (
            ("heading", "yaw", "rad"),
            ("roll_rate", "rollspeed", "rad/s"),
            ("pitch_rate", "pitchspeed", "rad/s"),
        )
        if f"{path}{field}" in topic.fields
    }
    voltage = _voltage(said)
    if voltage is not None:
        channels["voltage"] = voltage
    if "VFR_HUD" in said:
        hud, inside = said["VFR_HUD"]
        channels["depth"] = Source(topic=hud.name, field=f"{inside}alt", unit="m", sign=-1)
    thrusters, notes, missing = _thrusters(said, observed, voltage)
    inputs = Inputs(
        preset="blueos",
        yaw_rate=Source(topic=topic.name, field=f"{path}yawspeed", unit="rad/s", **clock),
        thrusters=thrusters,
        channels=channels,
        armed=_armed(said),
    )
    return Proposal(inputs, notes, missing)


def _messages(observed: Observed) -> Iterator[tuple[str, Topic, str]]:
    """The messages of the autopilot: name, topic, and where in a message the fields stand (`message.` in JSON)."""
    for topic in sorted(observed.topics, key=lambda each: each.count):  # the busiest vehicle is the one, and stays
        key = _KEY.match(topic.name)
        if key is None:
            if topic.type == topic.name:
                yield topic.name, topic, ""
        elif int(key[2]) == AUTOPILOT:
            inside = any(name.startswith("message.") for name in topic.fields)
            yield key[3], topic, "message." if inside else ""


def _armed(said: dict[str, tuple[Topic, str]]) -> Armed | None:
    """By the autopilot's own heartbeat: a ground station's and a camera's have the same bit."""
    if "HEARTBEAT" not in said:
        return None
    topic, path = said["HEARTBEAT"]
    bits = f"{path}base_mode.bits"
    return Armed(topic=topic.name, field=bits if bits in topic.fields else f"{path}base_mode", bit=ARMED)


def _voltage(said: dict[str, tuple[Topic, str]]) -> Source | None:
    for message, field in (("BATTERY_STATUS", "voltages[0]"), ("SYS_STATUS", "voltage_battery")):
        if message in said and f"{said[message][1]}{field}" in said[message][0].fields:
            topic, path = said[message]
            return Source(topic=topic.name, field=f"{path}{field}", unit="mV")
    return None


def _thrusters(
    said: dict[str, tuple[Topic, str]], observed: Observed, voltage: Source | None
) -> tuple[Thrusters | None, tuple[str, ...], dict[str, str]]:
    if "SERVO_OUTPUT_RAW" not in said:
        asks = "no SERVO_OUTPUT_RAW was found: let the vehicle send it (SR*_RC_CHAN), or take the vehicle's own .BIN"
        return None, (), {"torque": asks}
    kind, notes, missing = known_frame(observed)
    if kind is None:
        return None, notes, missing
    topic, path = said["SERVO_OUTPUT_RAW"]
    thrusters = Thrusters(
        topic=topic.name,
        command="pwm",
        each=frames.thrusters(observed.parameters, kind, f"{path}servo{{}}_raw"),
        measured_voltage=voltage,
        stamp=f"{path}time_usec",
        stamp_unit="us",
    )
    return thrusters, notes, {}


def known_frame(observed: Observed) -> tuple[int | None, tuple[str, ...], dict[str, str]]:
    """The frame by the vehicle's own parameters, what is to be said of it, and what is missing where none is known."""
    kind = frames.frame(observed.parameters)
    if kind is None:
        return 1, (frames.assumed(observed.parameters) or "",), {}
    if kind not in frames.FRAMES:
        cure = (
            f"the levers of frame {kind} are not known: describe the thrusters in inputs.thrusters of a configuration"
        )
        return None, (), {"torque": cure}
    names = [f"MOT_{motor}_DIRECTION" for motor in range(1, len(frames.YAW) + 1)]
    told = [f"{observed.parameters[name]:+.0f}" for name in names if name in observed.parameters]
    directions = f", directions {', '.join(told)}" if told else ", directions not told"
    return kind, (f"frame {kind} ({frames.FRAMES[kind]}){directions}, by the vehicle's parameters",), {}
