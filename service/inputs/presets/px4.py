"""PX4's logs: the rates, and the torque that the controller asked for as a part of what the vehicle can."""

from __future__ import annotations

from service.inputs.presets.proposal import NOTHING_FOUND, Observation, Proposal, source_of
from service.inputs.settings import Armed, Inputs, Source, StampedBy

_CLOCK = StampedBy(stamp="timestamp", stamp_unit="us")
YAW_FIELD = "xyz[2]"
"""The field of the axis downwards: clockwise seen from above."""
_QUANTITIES = (
    ("yaw_rate", "vehicle_angular_velocity", YAW_FIELD),
    ("torque", "vehicle_torque_setpoint", YAW_FIELD),
    ("armed", "actuator_armed", "armed"),
    ("state", "vehicle_status", "arming_state"),
    ("voltage", "battery_status", "voltage_v"),
)
"""Name, message and field of what a log has."""


def proposal(observed: Observation) -> Proposal | None:
    """The mapping of a PX4 log; None where it has no angular velocity."""
    places = {name: (message, field) for name, message, field in _QUANTITIES}
    found = {name: source_of(observed, name, *place) for name, place in places.items()}
    topics, reasons = {name: each[0] for name, each in found.items()}, {name: each[1] for name, each in found.items()}
    rate, setpoint, torque, armed = topics["yaw_rate"], topics["torque"], None, None
    if not rate:
        return None
    if setpoint:
        torque = Source(topic=setpoint, field=YAW_FIELD, unit="fraction", **_CLOCK)
        reasons["torque"] += (f"{setpoint} is a fraction of the full torque, without a unit until a scale is given",)
    if topics["armed"]:
        armed = Armed(topic=topics["armed"], field="armed", **_CLOCK)
    elif topics["state"]:
        armed = Armed(topic=topics["state"], field="arming_state", equals=2.0, **_CLOCK)
    channels = {
        name: Source(topic=rate, field=field, unit="rad/s", **_CLOCK)
        for name, field in (("roll_rate", "xyz[0]"), ("pitch_rate", "xyz[1]"))
    }
    if topics["voltage"]:
        channels["voltage"] = Source(topic=topics["voltage"], field="voltage_v", unit="V", **_CLOCK)
    inputs = Inputs(
        preset="px4",
        yaw_rate=Source(topic=rate, field=YAW_FIELD, unit="rad/s", **_CLOCK),
        torque=torque,
        channels=channels,
        armed=armed,
    )
    if torque is None:
        missing, unseen = {"torque": NOTHING_FOUND["torque"]}, frozenset({"torque"})
        return Proposal(inputs, missing=missing, reasons=reasons, unseen=unseen)
    return Proposal(inputs, reasons=reasons)
