"""ArduPilot's own logs (.BIN): the gyro, the outputs and the arming as the autopilot wrote them down."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from service.inputs import ardusub_frames
from service.inputs.presets.mavlink import frame_of
from service.inputs.presets.proposal import Observation, Proposal, source_of
from service.inputs.settings import Armed, Inputs, Source, StampedBy, Thrusters
from service.inputs.table import Topic

_CLOCK = StampedBy(stamp="TimeUS", stamp_unit="us")
_OUTPUTS = ("RCOU", "RCO2", "RCO3")
"""The messages that hold outputs: 1 to 14, and where there are more 15 to 18 and 19 to 32."""
_ARMED, _DISARMED = 10.0, 11.0
"""The events (EV.Id) of arming and disarming; all others say nothing of it."""


def proposal(observed: Observation) -> Proposal | None:
    """The mapping of an ArduPilot log; None where there is no gyro in it."""
    named = {topic.name: topic for topic in observed.topics}
    gyro, of_gyros = source_of(observed, "yaw_rate", "IMU", "GyrZ")
    if "TimeUS" not in (named[gyro].fields if gyro else ()):
        return None

    def source(topic: str, field: str, unit: str) -> Source | None:
        there = topic in named and field in named[topic].fields
        return Source(topic=topic, field=field, unit=unit, **_CLOCK) if there else None

    battery, of_batteries = source_of(observed, "voltage", "BAT", "Volt")
    voltage = source(battery, "Volt", "V")
    wanted = {
        "heading": source("ATT", "Yaw", "deg"),
        "roll_rate": source(gyro, "GyrX", "rad/s"),
        "pitch_rate": source(gyro, "GyrY", "rad/s"),
        "voltage": voltage,
    }
    thrusters, notes, missing = _thrusters(observed, named, voltage)
    inputs = Inputs(
        preset="blueos",
        yaw_rate=source(gyro, "GyrZ", "rad/s"),
        thrusters=thrusters,
        channels={name: each for name, each in wanted.items() if each is not None},
        armed=Armed(topic="ARM", field="ArmState", events=True, **_CLOCK)
        if "ARM" in named or "EV" not in named
        else Armed(topic="EV", field="Id", equals=_ARMED, disarmed=_DISARMED, events=True, **_CLOCK),
    )
    reasons = {"torque": notes, "yaw_rate": of_gyros, "voltage": of_batteries}
    return Proposal(inputs, missing=missing, reasons=reasons)


def _thrusters(
    observed: Observation, named: dict[str, Topic], voltage: Source | None
) -> tuple[Thrusters | None, tuple[str, ...], dict[str, str]]:
    if not any(name in named for name in _OUTPUTS):
        return None, (), {"torque": "no RCOU was found: let the vehicle log its outputs (bit 10 of LOG_BITMASK)"}
    place = partial(_place, named)
    kind, notes, missing = frame_of(observed, place)
    if kind is None:
        return None, notes, missing
    topic, each = ardusub_frames.at_one_topic(ardusub_frames.thrusters(observed.parameters, kind, place))
    return Thrusters(topic=topic, command="pwm", each=each, measured_voltage=voltage, **_CLOCK), notes, {}


def _place(named: Mapping[str, Topic], output: int) -> tuple[str, str]:
    """Message and field of an output; the first message where none has it."""
    field = f"C{output}"
    topic = next((name for name in _OUTPUTS if name in named and field in named[name].fields), _OUTPUTS[0])
    return topic, field
