"""The name of a topic: the vehicle that it is of, and the instance of its message.

The vehicle is the system of MAVLink, the entity of Keelson or the first part of a ROS name; the instance is the bank of
outputs, the battery or the sensor that a message names. Each instance is a topic of its own: instance 0 keeps the plain
name, `SERVO_OUTPUT_RAW`; another one is numbered, `SERVO_OUTPUT_RAW[1]`, in logs and on a bus alike.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from service.inputs.table import Topic

INSTANCE_FIELDS: Mapping[str, str] = {
    **dict.fromkeys(("SERVO_OUTPUT_RAW", "RC_CHANNELS_RAW", "RC_CHANNELS_SCALED"), "port"),
    **dict.fromkeys(
        (
            "AIRSPEED",
            "BATTERY_STATUS",
            "DISTANCE_SENSOR",
            "GLOBAL_POSITION_SENSOR",
            "HIGHRES_IMU",
            "HYGROMETER_SENSOR",
            "MCU_STATUS",
            "RAW_IMU",
            "SMART_BATTERY_INFO",
            "WATER_DEPTH",
        ),
        "id",
    ),
    **dict.fromkeys(("DEBUG_VECT", "NAMED_VALUE_FLOAT", "NAMED_VALUE_INT", "NAMED_VALUE_STRING"), "name"),
    "ADAP_TUNING": "axis",
    "OPTICAL_FLOW_RAD": "sensor_id",
    "PID_TUNING": "axis",
}
"""The field that tells instances apart, by MAVLink message: those that MAVLink's definitions mark, of measurements."""
_NUMBERED = re.compile(r"^(.*?)\[([^\[\]]+)\]$")


def instance_field(name: str) -> str | None:
    """The field that tells the instances of a MAVLink message apart, by the name of its topic or key."""
    return INSTANCE_FIELDS.get(name.rpartition("/")[2])


def numbered(name: str, which: Any) -> str:
    """The topic of one instance: the plain name for 0 and for what is no number and no name, else `NAME[1]`."""
    if isinstance(which, Mapping):  # JSON writes an enumerated value as {"type": "PID_TUNING_YAW"}
        which = which.get("type")
    if isinstance(which, list):  # and a text as its characters
        which = "".join(map(str, which))
    if isinstance(which, str):
        which = which.partition("\0")[0]
        return f"{name}[{which}]" if which and not set(which) & set("[]/") else name
    if isinstance(which, bool) or not isinstance(which, int | float) or which != which or which == 0:
        return name
    return f"{name}[{which:g}]"


def base(name: str) -> str:
    """The name without its instance."""
    found = _NUMBERED.match(name)
    return found[1] if found else name


def instance(name: str) -> str:
    """The instance that a name bears; empty for the plain one."""
    found = _NUMBERED.match(name)
    return found[2] if found else ""


def instance_place(name: str) -> tuple[bool, float, str]:
    """The place of a name among those of its message: the plain one first, then by number, then by name."""
    which = instance(name)
    return bool(which), float(which) if which.isdecimal() else float("inf"), which


AUTOPILOT = 1
"""The component that flies (MAV_COMP_ID_AUTOPILOT1)."""
_MAVLINK = re.compile(r"(?:^|.*/)mavlink/(\d+)/(\d+)/([A-Z0-9_]+(?:\[[^\[\]]+\])?)$")
_KEELSON = re.compile(r"^(?:.+/)?@v\d+/(.+)/pubsub/([^/]+)/.+$")
_RMW = re.compile(r"^\d+/(.+)/([a-z][a-z0-9_]*)::msg::dds_::([A-Za-z0-9]+)_/[^/]+$")


@dataclass(frozen=True, slots=True)
class MavlinkName:
    """The parts of the name of a MAVLink topic or key: `mavlink/<system>/<component>/<MESSAGE>[<instance>]`."""

    system: str
    component: int
    message: str


def mavlink(name: str) -> MavlinkName | None:
    """The parts of a MAVLink name; None where it is none."""
    found = _MAVLINK.match(name)
    return None if found is None else MavlinkName(found[1], int(found[2]), found[3])


def autopilot_message(topic: Topic) -> str | None:
    """The MAVLink message, with its instance, that a topic holds of an autopilot; None where it holds none.

    A telemetry log names the messages of its vehicle's autopilot without a system, and types them by the message.
    """
    parts = mavlink(topic.name)
    if parts is not None:
        return parts.message if parts.component == AUTOPILOT else None
    of_a_link = topic.type and topic.name.partition("[")[0] == topic.type
    return topic.name if of_a_link and topic.system else None


def keelson_subject(name: str) -> str | None:
    """The subject of a Keelson key; None where it is none."""
    found = _KEELSON.match(name)
    return None if found is None else found[2]


def ros_name(name: str) -> str:
    """A ROS topic as ROS calls it, without its leading slash, by its name in a log or by its key on a bus."""
    found = _RMW.match(name)
    return found[1] if found else name.removeprefix("/")


def ros_type(key: str) -> str | None:
    """The type that a key of rmw_zenoh names, such as `sensor_msgs/msg/Imu`; None where it names none."""
    found = _RMW.match(key)
    return None if found is None else f"{found[2]}/msg/{found[3]}"


def system_of(topic: Topic) -> str:
    """The vehicle whose a topic is; empty where nothing says so."""
    if topic.system:
        return topic.system
    parts = mavlink(topic.name)
    if parts is not None:
        return parts.system
    keelson = _KEELSON.match(topic.name)
    if keelson is not None:
        return keelson[1]
    if "/msg/" in topic.type:
        namespace, slash, _ = ros_name(topic.name).partition("/")
        return namespace if slash else ""
    return ""


def mavlink_topic(key: str, message: object) -> str:
    """The topic of a message in JSON that came under a MAVLink key: the key, with the instance that it names."""
    field = instance_field(key)
    if field is None or type(message) is not dict or type(message.get("message")) is not dict:
        return key
    return numbered(key, message["message"].get(field))
