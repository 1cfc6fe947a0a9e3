"""The vehicle of a topic, by its name: the system of MAVLink, the entity of Keelson, the first part of a ROS name."""

from __future__ import annotations

import re
from dataclasses import dataclass

from service.inputs.instances import instance_field, numbered
from service.inputs.table import Topic

AUTOPILOT = 1
"""The component that flies (MAV_COMP_ID_AUTOPILOT1)."""
_MAVLINK = re.compile(r"(?:^|.*/)mavlink/(\d+)/(\d+)/([A-Z0-9_]+(?:\[[^\[\]]+\])?)$")
_KEELSON = re.compile(r"^.+/@v\d+/(.+)/pubsub/([a-z0-9_]+)/.+$")
_RMW = re.compile(r"^\d+/(.+)/[a-z][a-z0-9_]*::msg::dds_::[A-Za-z0-9]+_/[^/]+$")


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
