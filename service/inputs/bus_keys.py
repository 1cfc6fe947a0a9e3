"""The keys of a bus that a mapping listens to, and the form and type of their messages.

A topic of the configuration may be a key expression, a ROS topic with its leading slash, which rmw_zenoh and
zenoh-bridge-ros2dds put on different keys, or, with the preset blueos, the name of a MAVLink message.
"""

from __future__ import annotations

import re

import zenoh

from incsvr.errors import BadInput
from service.inputs import presets
from service.inputs.owners import AUTOPILOT, base, instance, keelson_subject, ros_type
from service.inputs.settings import Inputs

BRIDGE_TOKENS = "@/*/@ros2_lv/MP/**"
"""Liveliness tokens by which zenoh-bridge-ros2dds says what is published: the key, with § for /, and the type."""
_TOKEN = re.compile(r"^@/[^/]+/@ros2_lv/MP/([^/]+)/([^/]+)(?:/.*)?$")
_MAVLINK = re.compile(r"^(?:.*/)?mavlink/[^/]+/[^/]+/[A-Z0-9_]+\[[^\[\]]+\]$")
_MESSAGE = re.compile(r"^[A-Z][A-Z0-9_]+(?:\[[^\[\]]+\])?$")


def key_expressions(inputs: Inputs) -> tuple[str, ...]:
    """The key expressions of a mapping, none within another.

    Raises:
        BadInput: a topic is no key expression, or the preset has nothing on a bus.
    """
    keys_of_preset = () if inputs.preset is None else presets.expressions(inputs.preset)
    if inputs.preset not in ("incsvr", None) and not keys_of_preset:
        raise BadInput(f"inputs.preset: {inputs.preset} is a preset of logs; on a bus use ros2, or blueos for MAVLink")
    wanted = dict.fromkeys(keys_of_preset)
    for place in inputs.places():
        for text in expressions(place.topic, inputs.preset):
            try:
                wanted[str(zenoh.KeyExpr(text))] = None
            except zenoh.ZError:
                raise BadInput(
                    f"inputs.{place.name}: {place.topic!r} is no key expression; write one such as vessel/imu/*"
                ) from None
    found = {text: zenoh.KeyExpr(text) for text in wanted}
    return tuple(
        text
        for text, key in found.items()
        if not any(other.includes(key) for name, other in found.items() if name != text)
    )


def expressions(topic: str, preset: str | None) -> tuple[str, ...]:
    """The key expressions on which a topic of a configuration may come, whichever instance of it is meant."""
    if preset == "blueos" and _MESSAGE.match(topic):
        return (f"mavlink/*/{AUTOPILOT}/{base(topic)}",)
    if _MAVLINK.match(topic):
        return (base(topic),)
    if topic.startswith("/"):
        return topic[1:], f"*{topic}/*/*"
    return (topic,)


def matches(topic: str, key: str, preset: str | None) -> bool:
    """Whether a key, with the instance that its messages name, is of a topic of the configuration."""
    if topic == key:
        return True
    if instance(topic) != instance(key):
        return False
    return any(zenoh.KeyExpr(each).includes(zenoh.KeyExpr(base(key))) for each in expressions(topic, preset))


def announced_type(token: str) -> tuple[str, str] | None:
    """Key and type of what a token of zenoh-bridge-ros2dds announces."""
    found = _TOKEN.match(token)
    return None if found is None else (found[1].replace("§", "/"), found[2].replace("§", "/"))


def form_of(key: str, announced: str | None, inputs: Inputs) -> str:
    """The form of a key's messages: as the key or its announced type says, as the configuration does, or JSON."""
    kind = ros_type(key) or announced
    if kind:
        return f"cdr:{kind}"
    if keelson_subject(key) is not None:
        return "keelson"
    return next((place.form for place in inputs.places() if matches(place.topic, key, inputs.preset)), "json")
