"""ArduSub's own logs (.BIN): the gyro, the outputs and the arming as the autopilot wrote them down."""

from __future__ import annotations

from service.inputs import frames
from service.inputs.presets.mavlink import known_frame
from service.inputs.presets.proposal import Observed, Proposal, first
from service.inputs.settings import Armed, Inputs, Source, StampedBy, Thrusters
from service.logs.table import Topic

_CLOCK = StampedBy(stamp="TimeUS", stamp_unit="us")


def proposal(observed: Observed) -> Proposal | None:
    """The mapping of an ArduPilot log; None where there is no gyro in it."""
    named = {topic.name: topic for topic in observed.topics}
    gyro = first((named[name] for name in ("IMU",) if name in named), "GyrZ", "TimeUS")
    if gyro is None:
        return None

    def source(topic: str, field: str, unit: str) -> Source | None:
        there = topic in named and field in named[topic].fields
        return Source(topic=topic, field=field, unit=unit, **_CLOCK) if there else None

    voltage = source("BAT", "Volt", "V")
    wanted = {
        "heading": source("ATT", "Yaw", "deg"),
        "roll_rate": source("IMU", "GyrX", "rad/s"),
        "pitch_rate": source("IMU", "GyrY", "rad/s"),
        "voltage": voltage,
    }
    thrusters, notes, missing = _thrusters(observed, named, voltage)
    inputs = Inputs(
        preset="blueos",
        yaw_rate=source("IMU", "GyrZ", "rad/s"),
        thrusters=thrusters,
        channels={name: each for name, each in wanted.items() if each is not None},
        armed=Armed(topic="ARM", field="ArmState", events=True, **_CLOCK)
        if "ARM" in named or "EV" not in named
        else Armed(topic="EV", field="Id", equals=10.0, events=True, **_CLOCK),
    )
    return Proposal(inputs, notes, missing)


def _thrusters(
    observed: Observed, named: dict[str, Topic], voltage: Source | None
) -> tuple[Thrusters | None, tuple[str, ...], dict[str, str]]:
    if "RCOU" not in named:
        return None, (), {"torque": "no RCOU was found: let the vehicle log its outputs (bit 10 of LOG_BITMASK)"}
    kind, notes, missing = known_frame(observed)
    if kind is None:
        return None, notes, missing
    each = frames.thrusters(observed.parameters, kind, "C{}")
    return Thrusters(topic="RCOU", command="pwm", each=each, measured_voltage=voltage, **_CLOCK), notes, {}
