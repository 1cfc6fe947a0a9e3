"""ROS 1 and ROS 2, by the types of the messages; ROS's axes count counter-clockwise, torque and rate alike."""

from __future__ import annotations

from service.inputs.presets.proposal import NOTHING, Observed, Proposal, first
from service.inputs.settings import Armed, Inputs, Source
from service.logs.table import Topic

RATES = {
    "sensor_msgs/msg/Imu": "angular_velocity.z",
    "nav_msgs/msg/Odometry": "twist.twist.angular.z",
    "geometry_msgs/msg/TwistWithCovarianceStamped": "twist.twist.angular.z",
    "geometry_msgs/msg/TwistStamped": "twist.angular.z",
    "geometry_msgs/msg/Vector3Stamped": "vector.z",
}
TORQUES = {"geometry_msgs/msg/WrenchStamped": "wrench.torque.z", "geometry_msgs/msg/Wrench": "torque.z"}
STATE = "mavros_msgs/msg/State"
READ = (*RATES, *TORQUES, STATE)
"""The types whose keys are listened to on a bus."""
_STAMP = "header.stamp"


def proposal(observed: Observed) -> Proposal | None:
    """The mapping by types; None where nothing has a yaw rate."""
    rates = [topic for topic in observed.typed(*RATES) if RATES[topic.type] in topic.fields]
    if not rates:
        return None
    torques = [topic for topic in observed.typed(*TORQUES) if TORQUES[topic.type] in topic.fields]
    notes = []
    for name, found in (("yaw_rate", rates), ("torque", torques)):
        if len(found) > 1:
            others = ", ".join(topic.name for topic in found[1:])
            notes.append(f"{name} is taken from {found[0].name}; {others} could be it, too")
    commands = observed.typed("std_msgs/msg/Float64MultiArray", "mavros_msgs/msg/RCOut")
    missing = {}
    if not torques:
        cure = f" (their commands may be {commands[0].name})" if commands else ""
        missing["torque"] = NOTHING["torque"] + cure
    state = first(observed.typed(STATE), "armed")
    odometry = first(observed.typed("nav_msgs/msg/Odometry"), "twist.twist.linear.x", "twist.twist.linear.y")
    channels = {}
    if odometry is not None:
        channels = {
            "surge": _source(odometry, "twist.twist.linear.x", "m/s"),
            "sway": _source(odometry, "twist.twist.linear.y", "m/s"),
        }
    rate = rates[0]
    if rate.type == "sensor_msgs/msg/Imu":
        channels["roll_rate"] = _source(rate, "angular_velocity.x", "rad/s")
        channels["pitch_rate"] = _source(rate, "angular_velocity.y", "rad/s")
    inputs = Inputs(
        preset="ros2",
        yaw_rate=_source(rate, RATES[rate.type], "rad/s"),
        torque=_source(torques[0], TORQUES[torques[0].type], "N m") if torques else None,
        channels=channels,
        armed=None if state is None else Armed(topic=state.name, field="armed", form=f"cdr:{STATE}"),
    )
    return Proposal(inputs, tuple(notes), missing)


def _source(topic: Topic, field: str, unit: str) -> Source:
    stamp = _STAMP if _STAMP in topic.fields else ""
    return Source(topic=topic.name, field=field, unit=unit, stamp=stamp, form=f"cdr:{topic.type}")
