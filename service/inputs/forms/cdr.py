"""CDR, as ROS 2 writes it: four bytes that name the byte order, then the fields, each aligned to its own size.

The common types by which vehicles tell rates, torques, commands and states are known here, so that a vehicle needs no
package for them. Source: OMG DDS-XTypes 1.3, 7.4.3 (XCDR version 1), and the definitions of the ROS 2 packages.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from functools import cache
from math import atan2, nan
from typing import Any

_GEOMETRY = {
    "Vector3": "f64 x, f64 y, f64 z",
    "Point": "f64 x, f64 y, f64 z",
    "Quaternion": "f64 x, f64 y, f64 z, f64 w",
    "Pose": "geometry_msgs/msg/Point position, geometry_msgs/msg/Quaternion orientation",
    "PoseWithCovariance": "geometry_msgs/msg/Pose pose, f64[36] covariance",
    "Twist": "geometry_msgs/msg/Vector3 linear, geometry_msgs/msg/Vector3 angular",
    "TwistWithCovariance": "geometry_msgs/msg/Twist twist, f64[36] covariance",
    "Wrench": "geometry_msgs/msg/Vector3 force, geometry_msgs/msg/Vector3 torque",
    "Vector3Stamped": "header, geometry_msgs/msg/Vector3 vector",
    "PoseStamped": "header, geometry_msgs/msg/Pose pose",
    "TwistStamped": "header, geometry_msgs/msg/Twist twist",
    "TwistWithCovarianceStamped": "header, geometry_msgs/msg/TwistWithCovariance twist",
    "WrenchStamped": "header, geometry_msgs/msg/Wrench wrench",
}
_NUMBERS = {
    "Bool": "bool data",
    "Float32": "f32 data",
    "Float64": "f64 data",
    "Int16": "i16 data",
    "Int32": "i32 data",
    "UInt16": "u16 data",
    **{
        f"{name}MultiArray": f"std_msgs/msg/MultiArrayLayout layout, {kind}[] data"
        for name, kind in (
            ("Float32", "f32"),
            ("Float64", "f64"),
            ("Int16", "i16"),
            ("Int32", "i32"),
            ("UInt16", "u16"),
        )
    },
    "Header": "time stamp, string frame_id",
    "MultiArrayDimension": "string label, u32 size, u32 stride",
    "MultiArrayLayout": "std_msgs/msg/MultiArrayDimension[] dim, u32 data_offset",
}
_VECTOR = "geometry_msgs/msg/Vector3"
TYPES: Mapping[str, str] = {
    **{f"geometry_msgs/msg/{name}": fields for name, fields in _GEOMETRY.items()},
    **{f"std_msgs/msg/{name}": fields for name, fields in _NUMBERS.items()},
    "sensor_msgs/msg/Imu": (
        "header, geometry_msgs/msg/Quaternion orientation, f64[9] orientation_covariance, "
        f"{_VECTOR} angular_velocity, f64[9] angular_velocity_covariance, "
        f"{_VECTOR} linear_acceleration, f64[9] linear_acceleration_covariance"
    ),
    "sensor_msgs/msg/FluidPressure": "header, f64 fluid_pressure, f64 variance",
    "sensor_msgs/msg/Temperature": "header, f64 temperature, f64 variance",
    "sensor_msgs/msg/JointState": "header, string[] name, f64[] position, f64[] velocity, f64[] effort",
    "sensor_msgs/msg/BatteryState": (
        "header, f32 voltage, f32 temperature, f32 current, f32 charge, f32 capacity, f32 design_capacity, "
        "f32 percentage, u8 power_supply_status, u8 power_supply_health, u8 power_supply_technology, bool present, "
        "f32[] cell_voltage, f32[] cell_temperature, string location, string serial_number"
    ),
    "nav_msgs/msg/Odometry": (
        "header, string child_frame_id, geometry_msgs/msg/PoseWithCovariance pose, "
        "geometry_msgs/msg/TwistWithCovariance twist"
    ),
    "mavros_msgs/msg/RCOut": "header, u16[] channels",
    "mavros_msgs/msg/State": (
        "header, bool connected, bool armed, bool guided, bool manual_input, string mode, u8 system_status"
    ),
    "diagnostic_msgs/msg/KeyValue": "string key, string value",
    "diagnostic_msgs/msg/DiagnosticStatus": (
        "u8 level, string name, string message, string hardware_id, diagnostic_msgs/msg/KeyValue[] values"
    ),
    "diagnostic_msgs/msg/DiagnosticArray": "header, diagnostic_msgs/msg/DiagnosticStatus[] status",
}
"""The fields of each type in their order."""
_LETTERS = {
    "bool": "?",
    "u8": "B",
    "i16": "h",
    "u16": "H",
    "i32": "i",
    "u32": "I",
    "f32": "f",
    "f64": "d",
}
ONE, MANY = -1, -2
"""The number of a field's items: one, or as many as the message says."""
MAX_SEQUENCE_ITEMS = 100_000
"""Items of a sequence at most: what claims more is no message of these types."""
QUATERNION = "geometry_msgs/msg/Quaternion"
LITTLE, BIG = b"\x00\x01\x00\x00", b"\x00\x00\x00\x00"


def decode(payload: bytes, name: str) -> dict[str, Any]:
    """The fields of a message of a known type, nested; stamps in seconds.

    Raises:
        ValueError: it is no such message.
    """
    if payload[:2] not in (LITTLE[:2], BIG[:2]):
        raise ValueError("it does not begin as CDR does")
    reader = _Reader(payload, "<" if payload[1] else ">")
    try:
        return reader.message(name)
    except (struct.error, UnicodeDecodeError) as error:
        raise ValueError(str(error)) from None


def with_yaw(quaternion: dict[str, Any]) -> dict[str, Any]:
    """A quaternion with its turn about the vertical axis [rad] beside, NaN where its driver left it empty."""
    x, y, z, w = (quaternion[name] for name in "xyzw")
    yaw = atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z) if any((x, y, z, w)) else nan
    return {**quaternion, "yaw": yaw}


def encode(name: str, message: Mapping[str, Any]) -> bytes:
    """A message of a known type, little-endian; stamps are nanoseconds since 1970."""
    writer = _Writer()
    writer.message(name, message)
    return LITTLE + bytes(writer.content)


@cache
def fields(name: str) -> tuple[tuple[str, str, int], ...]:
    """The fields of a type: name, kind, and how many there are of it."""
    found = []
    for text in TYPES[name].split(", "):
        kind, _, field = ("std_msgs/msg/Header header" if text == "header" else text).partition(" ")
        kind, bracket, size = kind.partition("[")
        count = ONE if not bracket else int(size[:-1]) if size[:-1] else MANY
        found.append((field, kind, count))
    return tuple(found)


class _Reader:
    def __init__(self, payload: bytes, order: str) -> None:
        self._payload, self._order, self._place = payload, order, 4

    def message(self, name: str) -> dict[str, Any]:
        found = {field: self._field(kind, count) for field, kind, count in fields(name)}
        return with_yaw(found) if name == QUATERNION else found

    def _field(self, kind: str, count: int) -> Any:
        if count == ONE:
            return self._one(kind)
        if count == MANY:
            (count,) = self._numbers("I", 4, 1)
            if count > MAX_SEQUENCE_ITEMS:
                raise ValueError(f"a sequence of {count} items is too long")
        if kind in _LETTERS:
            letter = _LETTERS[kind]
            return list(self._numbers(letter, struct.calcsize(letter), count)) if count else []
        return [self._one(kind) for _ in range(count)]

    def _one(self, kind: str) -> Any:
        if kind in _LETTERS:
            letter = _LETTERS[kind]
            return self._numbers(letter, struct.calcsize(letter), 1)[0]
        if kind == "time":
            (seconds,), (nanoseconds,) = self._numbers("i", 4, 1), self._numbers("I", 4, 1)
            return seconds + nanoseconds * 1e-9
        if kind == "string":
            (size,) = self._numbers("I", 4, 1)
            text = self._payload[self._place : self._place + size]
            if len(text) < size:
                raise ValueError("it ends within a text")
            self._place += size
            return text.rstrip(b"\0").decode()
        return self.message(kind)

    def _numbers(self, letter: str, size: int, count: int) -> tuple[Any, ...]:
        self._place += -(self._place - 4) % size
        found = struct.unpack_from(f"{self._order}{count}{letter}", self._payload, self._place)
        self._place += size * count
        return found


class _Writer:
    def __init__(self) -> None:
        self.content = bytearray()

    def message(self, name: str, message: Mapping[str, Any]) -> None:
        for field, kind, count in fields(name):
            self._field(kind, count, message[field])

    def _field(self, kind: str, count: int, value: Any) -> None:
        if count == ONE:
            self._one(kind, value)
            return
        items: Sequence[Any] = value
        if count == MANY:
            self._one("u32", len(items))
        for item in items:
            self._one(kind, item)

    def _one(self, kind: str, value: Any) -> None:
        if kind in _LETTERS:
            packed = struct.pack(f"<{_LETTERS[kind]}", value)
            self.content += b"\0" * (-len(self.content) % len(packed)) + packed
        elif kind == "time":
            self._one("i32", value // 10**9)
            self._one("u32", value % 10**9)
        elif kind == "string":
            text = str(value).encode() + b"\0"
            self._one("u32", len(text))
            self.content += text
        else:
            self.message(kind, value)
