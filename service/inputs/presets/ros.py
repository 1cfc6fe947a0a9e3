"""ROS 1 and ROS 2, by the types of the messages; ROS's axes count counter-clockwise, torque and rate alike."""

from __future__ import annotations

import re
from collections.abc import Mapping

from service.inputs.owners import ros_name
from service.inputs.presets.proposal import NOTHING_FOUND, Observation, Proposal, first, others_note
from service.inputs.settings import Armed, Inputs, Source
from service.inputs.table import HEADER_STAMP, Topic

RATE_PATHS = {
    "sensor_msgs/msg/Imu": "angular_velocity.z",
    "nav_msgs/msg/Odometry": "twist.twist.angular.z",
    "geometry_msgs/msg/TwistWithCovarianceStamped": "twist.twist.angular.z",
    "geometry_msgs/msg/TwistStamped": "twist.angular.z",
    "geometry_msgs/msg/Vector3Stamped": "vector.z",
}
TORQUE_PATHS = {"geometry_msgs/msg/WrenchStamped": "wrench.torque.z", "geometry_msgs/msg/Wrench": "torque.z"}
NO_RATE_FIELD = "angular_velocity_covariance[0]"
"""−1 in an Imu that has no rate."""
STATE_TYPE = "mavros_msgs/msg/State"
LISTENED_TYPES = (*RATE_PATHS, *TORQUE_PATHS, STATE_TYPE)
"""The types whose keys are listened to on a bus."""
KEYS = tuple(f"*/**/{kind.replace('/msg/', '::msg::dds_::')}_/*" for kind in LISTENED_TYPES)
"""These keys, as rmw_zenoh names them."""
_NOT_THE_VEHICLES = re.compile(
    r"(?:^|[/_])(?:camera|cam|zed|realsense|oak|depthai|stereo|kinect|d4\d\d|t265|lidar|ouster|livox|gimbal)"
    r"[a-z0-9]*(?:[/_]|$)"
)
"""Names of sensors that bring an Imu of their own, in axes of their own: a camera's z is where it looks."""


def proposal(observed: Observation) -> Proposal | None:
    """The mapping by types; None where nothing has a yaw rate."""
    torques = _candidates(observed, TORQUE_PATHS)
    rates = _candidates(observed, RATE_PATHS, beside=torques[0] if torques else None)
    if not rates:
        return None
    reasons = {}
    for name, found in (("yaw_rate", rates), ("torque", torques)):
        first_own = any(map(_foreign, found)) and not _foreign(found[0])
        why = "the first by its name" + (" that is no camera's" if first_own else "")
        if found and any(_rank(observed, each) > _rank(observed, found[0]) for each in found[1:]):
            why = "the first by its name whose values move"
        reasons[name] = others_note(name, found[0].name, [topic.name for topic in found[1:]], why) if found else ()
    commands = observed.of_types("std_msgs/msg/Float64MultiArray", "mavros_msgs/msg/RCOut")
    missing = {}
    if not torques:
        cure = f" (their commands may be {commands[0].name})" if commands else ""
        missing["torque"] = NOTHING_FOUND["torque"] + cure
    state = first(observed.of_types(STATE_TYPE), "armed")
    odometry = first(observed.of_types("nav_msgs/msg/Odometry"), "twist.twist.linear.x", "twist.twist.linear.y")
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
        yaw_rate=_source(rate, RATE_PATHS[rate.type], "rad/s"),
        torque=_source(torques[0], TORQUE_PATHS[torques[0].type], "N m") if torques else None,
        channels=channels,
        armed=None if state is None else Armed(topic=state.name, field="armed", form=f"cdr:{STATE_TYPE}"),
    )
    return Proposal(inputs, missing=missing, reasons=reasons, unseen=frozenset(missing))


def _candidates(observed: Observation, types: Mapping[str, str], beside: Topic | None = None) -> list[Topic]:
    """The topics that have the field of their type, the likeliest first; how busy they are says nothing.

    Those come first that are no camera's, then those whose values move, then those of the earlier types, then those
    that share the first part of their name with the topic `beside`, then those with the shortest and the first names.
    """
    share = None if beside is None else ros_name(beside.name).partition("/")[0]

    def place(topic: Topic) -> tuple[bool, int, int, bool, int, str]:
        name = ros_name(topic.name)
        apart = share is not None and name.partition("/")[0] != share
        return _foreign(topic), _rank(observed, topic), list(types).index(topic.type), apart, name.count("/"), name

    return sorted((topic for topic in observed.of_types(*types) if types[topic.type] in topic.fields), key=place)


def _rank(observed: Observation, topic: Topic) -> int:
    return observed.ranks.get((topic.name, {**RATE_PATHS, **TORQUE_PATHS}.get(topic.type, "")), 0)


def _foreign(topic: Topic) -> bool:
    return _NOT_THE_VEHICLES.search(ros_name(topic.name).lower()) is not None


def _source(topic: Topic, field: str, unit: str) -> Source:
    stamp = HEADER_STAMP if HEADER_STAMP in topic.fields else ""
    return Source(topic=topic.name, field=field, unit=unit, stamp=stamp, form=f"cdr:{topic.type}")
