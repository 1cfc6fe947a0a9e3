"""Messages of ROS 1 and ROS 2, by their own definitions, through the package rosbags."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from service.cli.extras import load_package


class RosTypes:
    """The types of messages that are known: those of common packages, and those that a log defines itself."""

    def __init__(self, path: Path | str, one: bool = False) -> None:
        self._typesys = load_package("rosbags.typesys", path, "a message of ROS")
        stores = self._typesys.Stores
        self._store = self._typesys.get_typestore(stores.ROS1_NOETIC if one else stores.ROS2_JAZZY)
        self._one = one

    def define(self, name: str, text: str, idl: bool = False) -> None:
        """A type by the text of its definition, as MCAP files and bags hold it."""
        typesys = self._typesys
        types = typesys.get_types_from_idl(text) if idl else typesys.get_types_from_msg(text, full_name(name))
        self._store.register({each: fields for each, fields in types.items() if each not in self._store.fielddefs})

    def knows(self, name: str) -> bool:
        return full_name(name) in self._store.fielddefs

    def decode(self, payload: bytes, name: str) -> dict[str, Any]:
        """The fields of a message, nested; stamps and durations as seconds."""
        read = self._store.deserialize_ros1 if self._one else self._store.deserialize_cdr
        return dict(_fields(read(payload, full_name(name))))


def full_name(name: str) -> str:
    """`sensor_msgs/msg/Imu` for the `sensor_msgs/Imu` of ROS 1."""
    package, _, rest = name.partition("/")
    return name if rest.startswith(("msg/", "srv/", "action/")) else f"{package}/msg/{rest}"


def _fields(message: Any) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name in message.__dataclass_fields__:
        if name == "__msgtype__":
            continue
        found[name] = _plain(getattr(message, name))
    return found


def _plain(value: Any) -> Any:
    if hasattr(value, "nanosec"):
        return value.sec + value.nanosec * 1e-9
    if hasattr(value, "__dataclass_fields__"):
        return _fields(value)
    if isinstance(value, list):
        return [_plain(item) for item in value]
    return value
