"""PX4's logs: the rates, and the torque that the controller asked for as a part of what the vehicle can."""

from __future__ import annotations

from service.inputs.presets.proposal import NOTHING, Observed, Proposal
from service.inputs.settings import Armed, Inputs, Source, StampedBy

_CLOCK = StampedBy(stamp="timestamp", stamp_unit="us")
YAW = "xyz[2]"
"""The axis downwards: clockwise seen from above."""


def proposal(observed: Observed) -> Proposal | None:
    """The mapping of a PX4 log; None where it has no angular velocity."""
    named = {topic.name: topic for topic in observed.topics}
    rate = named.get("vehicle_angular_velocity")
    if rate is None or YAW not in rate.fields:
        return None
    torque = None
    notes: tuple[str, ...] = ()
    if "vehicle_torque_setpoint" in named:
        torque = Source(topic="vehicle_torque_setpoint", field=YAW, unit="fraction", **_CLOCK)
        notes = ("vehicle_torque_setpoint is a part of the full torque, without a unit until a scale is given",)
    armed = None
    if "actuator_armed" in named:
        armed = Armed(topic="actuator_armed", field="armed", **_CLOCK)
    elif "vehicle_status" in named:
        armed = Armed(topic="vehicle_status", field="arming_state", equals=2.0, **_CLOCK)
    channels = {
        name: Source(topic=rate.name, field=field, unit="rad/s", **_CLOCK)
        for name, field in (("roll_rate", "xyz[0]"), ("pitch_rate", "xyz[1]"))
    }
    if "battery_status" in named:
        channels["voltage"] = Source(topic="battery_status", field="voltage_v", unit="V", **_CLOCK)
    inputs = Inputs(
        preset="px4",
        yaw_rate=Source(topic=rate.name, field=YAW, unit="rad/s", **_CLOCK),
        torque=torque,
        channels=channels,
        armed=armed,
    )
    return Proposal(inputs, notes, {} if torque else {"torque": NOTHING["torque"]})
