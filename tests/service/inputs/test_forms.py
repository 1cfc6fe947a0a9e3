"""The forms of messages, against bytes that the formats' own libraries write, and against bytes that are broken."""

from __future__ import annotations

from typing import Any

import keelson
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from keelson.payloads.Primitives_pb2 import TimestampedBool, TimestampedFloat, TimestampedInt
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from service.inputs.forms import Undecodable, cdr, decoder, json5, number
from service.logs.bag_log import RosTypes

STORE: Any = get_typestore(Stores.ROS2_JAZZY)
MAVROS = {
    "mavros_msgs/msg/RCOut": "std_msgs/Header header\nuint16[] channels\n",
    "mavros_msgs/msg/State": (
        "std_msgs/Header header\nbool connected\nbool armed\nbool guided\nbool manual_input\nstring mode\n"
        "uint8 system_status\n"
    ),
}
for name, text in MAVROS.items():
    STORE.register(get_types_from_msg(text, name))
ONES = {"bool": 1, "u8": 100, "i16": -3, "u16": 1540, "i32": -70_000, "u32": 5, "f32": 0.5, "f64": -1.25e-3}


def some(kind: str, rng: np.random.Generator) -> Any:
    """A message of rosbags, or a value in one, with sequences of any length and texts that spoil the alignment."""
    if kind == "time":
        return STORE.types["builtin_interfaces/msg/Time"](1_700_000_000, 250_000_000)
    if kind == "string":
        return "x" * int(rng.integers(0, 9))
    if kind in ONES:
        return bool(ONES[kind]) if kind == "bool" else ONES[kind]
    values = {}
    for field, inner, count in cdr.fields(kind):
        size = int(rng.integers(0, 4)) if count == cdr.MANY else count
        if count == cdr.ONE:
            values[field] = some(inner, rng)
        elif inner in ONES:
            names = {"f32": np.float32, "f64": np.float64, "i16": np.int16, "i32": np.int32, "u16": np.uint16}
            values[field] = np.full(size, ONES[inner], dtype=names[inner])
        else:
            values[field] = [some(inner, rng) for _ in range(size)]
    return STORE.types[kind](**values)


def plain(value: Any) -> Any:
    """The same as JSON has it, without the constants of a type, which rosbags tells as fields."""
    if isinstance(value, dict):
        return {name: plain(each) for name, each in value.items() if not name.isupper()}
    if isinstance(value, list):
        return [plain(each) for each in value]
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


@pytest.mark.parametrize("kind", sorted(cdr.TYPES))
def test_cdr_is_read_as_rosbags_writes_it(kind: str) -> None:
    oracle = RosTypes("test")
    for name, text in MAVROS.items():
        oracle.define(name, text)
    for seed in range(8):
        message = some(kind, np.random.default_rng(seed))
        for little in (True, False):
            payload = bytes(STORE.serialize_cdr(message, kind, little_endian=little))
            assert cdr.decode(payload, kind) == plain(oracle.decode(payload, kind))


def test_diagnostics_are_written_as_rosbags_reads_them() -> None:
    values = [{"key": "samples", "value": "17"}, {"key": "µ", "value": ""}]
    status = [{"level": 1, "name": "leng/yaw", "message": "learning", "hardware_id": "leng", "values": values}] * 2
    header = {"stamp": 1_700_000_000_250_000_000, "frame_id": ""}
    kind = "diagnostic_msgs/msg/DiagnosticArray"
    payload = cdr.encode(kind, {"header": header, "status": status})
    message = STORE.deserialize_cdr(payload, kind)
    assert bytes(STORE.serialize_cdr(message, kind)).rstrip(b"\0") == payload.rstrip(b"\0")
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (1_700_000_000, 250_000_000)
    assert [(each.key, each.value) for each in message.status[1].values] == [("samples", "17"), ("µ", "")]


@pytest.mark.parametrize(
    ("message", "value"),
    [
        (TimestampedFloat(value=-12.5), -12.5),
        (TimestampedBool(value=True), 1.0),
        (TimestampedBool(), 0.0),
        (TimestampedInt(value=-3), -3.0),
    ],
)
def test_keelsons_envelopes(message: Any, value: float) -> None:
    message.timestamp.FromNanoseconds(1_700_000_000_250_000_000)
    decoded = decoder("keelson")(keelson.enclose(message.SerializeToString()))
    assert number(decoded, "value") == value
    assert number(decoded, "timestamp") == pytest.approx(1_700_000_000.25, abs=1e-6)


@pytest.mark.parametrize("form", ["json", "keelson", "cdr:sensor_msgs/msg/Imu", "cdr:std_msgs/msg/Float64MultiArray"])
@given(payload=st.binary(max_size=400))
def test_any_bytes_are_read_or_refused(form: str, payload: bytes) -> None:
    for prefix in (b"", b"\0\1\0\0", b"\x12\x20\x0a\x08"):
        try:
            decoder(form)(prefix + payload)
        except Undecodable:
            continue


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("{message: {type: 'ATTITUDE', yawspeed: +.5,}, }", {"message": {"type": "ATTITUDE", "yawspeed": 0.5}}),
        ("[0x10, -0x1, 1., -.25e1, 7]", [16, -1, 1.0, -2.5, 7]),
        (
            "{a: Infinity, b: -Infinity, $c: true, d_1: null} // end",
            {"a": np.inf, "b": -np.inf, "$c": True, "d_1": None},
        ),
        ("/* so */ {'it\\'s': 'a \"b\" c'}", {"it's": 'a "b" c'}),
        ('{"plain": [1, 2.5, "x, y]"]}', {"plain": [1, 2.5, "x, y]"]}),
    ],
)
def test_json5_as_its_specification_has_it(text: str, value: Any) -> None:
    assert json5.read(text.encode()) == value


@pytest.mark.parametrize("text", ["{a: }", "{,}", "[1 2]", "{a: b c}", "'open", "[" * 30_000, "{a: 1", "\u00e9"])
def test_what_is_no_json5_is_refused(text: str) -> None:
    with pytest.raises(Undecodable):
        decoder("json")(text.encode())
