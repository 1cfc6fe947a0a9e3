"""PX4's logs: the rates, and the torque that the controller asked for as a part of what the vehicle can."""

from __future__ import annotations

from service.inputs.presets.proposal import NOTHING_FOUND, Observation, Proposal, instances, others_note
from service.inputs.settings import Armed, Inputs, Source, StampedBy
from service.inputs.table import Topic

_CLOCK = StampedBy(stamp="timestamp", stamp_unit="us")
YAW_FIELD = "xyz[2]"
"""The field of the axis downwards: clockwise seen from above."""


def proposal(observed: Observation) -> Proposal | None:
    """The mapping of a PX4 log; None where it has no angular velocity."""
    named = {topic.name: topic for topic in observed.topics}
    reasons: dict[str, tuple[str, ...]] = {}

    def source_of(quantity: str, message: str, field: str) -> Topic | None:
        found = [name for name in instances(named, message) if field in named[name].fields]
        found = [name for name in found if name not in observed.absent_batteries] or found
        found.sort(key=lambda name: observed.ranks.get((name, field), 0))
        reasons[quantity] = others_note(quantity, found[0], found[1:]) if found else ()
        return named[found[0]] if found else None

    rate = source_of("yaw_rate", "vehicle_angular_velocity", YAW_FIELD)
    if rate is None:
        return None
    setpoint, torque = source_of("torque", "vehicle_torque_setpoint", YAW_FIELD), None
    if setpoint is not None:
        torque = Source(topic=setpoint.name, field=YAW_FIELD, unit="fraction", **_CLOCK)
        reasons["torque"] += (
            f"{setpoint.name} is a fraction of the full torque, without a unit until a scale is given",
        )
    armed = None
    if (state := source_of("armed", "actuator_armed", "armed")) is not None:
        armed = Armed(topic=state.name, field="armed", **_CLOCK)
    elif (state := source_of("armed", "vehicle_status", "arming_state")) is not None:
        armed = Armed(topic=state.name, field="arming_state", equals=2.0, **_CLOCK)
    channels = {
        name: Source(topic=rate.name, field=field, unit="rad/s", **_CLOCK)
        for name, field in (("roll_rate", "xyz[0]"), ("pitch_rate", "xyz[1]"))
    }
    battery = source_of("voltage", "battery_status", "voltage_v")
    if battery is not None:
        channels["voltage"] = Source(topic=battery.name, field="voltage_v", unit="V", **_CLOCK)
    inputs = Inputs(
        preset="px4",
        yaw_rate=Source(topic=rate.name, field=YAW_FIELD, unit="rad/s", **_CLOCK),
        torque=torque,
        channels=channels,
        armed=armed,
    )
    if torque is None:
        missing, unseen = {"torque": NOTHING_FOUND["torque"]}, frozenset({"torque"})
        return Proposal(inputs, missing=missing, reasons=reasons, unseen=unseen)
    return Proposal(inputs, reasons=reasons)
