"""Logs of middleware: MCAP and bags, written by mcap, rosbags and keelson themselves, and CDR by hand."""

from __future__ import annotations

import json
import struct
import time as clock
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import keelson
import numpy as np
import pytest
from keelson.payloads.Primitives_pb2 import TimestampedBool, TimestampedFloat
from mcap.writer import Writer
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.axes import AXES
from service.inputs.forms import cdr
from service.logs import open_any
from service.logs.bag_log import RosTypes
from service.recordings.reading import Reading
from service.recordings.recording import Recording
from tests.service import link
from tests.service.logs.dive import BOOT, EPOCH, dive, read

DIVE = dive(seconds=10.0)
ROS2 = get_typestore(Stores.ROS2_JAZZY)
ROS1 = get_typestore(Stores.ROS1_NOETIC)
IMU, WRENCH = "sensor_msgs/msg/Imu", "geometry_msgs/msg/Wrench"


def same(recording: Recording, begin: float, torque: Array = DIVE.torque, late: float = 0.0) -> None:
    for name, values, shift in (("yaw_rate", DIVE.rate, 0.0), ("torque", torque, late)):
        time, got = recording.streams()[name]
        np.testing.assert_allclose(time - begin - shift, DIVE.time, atol=1e-5)
        np.testing.assert_allclose(got, values, atol=1e-5)


def stamp(seconds: float) -> tuple[int, int]:
    whole = round(1e9 * seconds)
    return whole // 10**9, whole % 10**9


def imu(store: Any, at: float, rate: float) -> Any:
    types = store.types
    vector, still = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
    when = types["builtin_interfaces/msg/Time"](*stamp(at))
    head = {"stamp": when, "frame_id": "base_link"}
    if store is ROS1:
        head = {"seq": 0, **head}
    header = types["std_msgs/msg/Header"](**head)
    none = np.zeros(9)
    turn, pull = vector(0.0, 0.0, rate), vector(0.0, 0.0, 9.8)
    return types["sensor_msgs/msg/Imu"](header, still, none, turn, none, pull, none)


def wrench(store: Any, torque: float) -> Any:
    vector = store.types["geometry_msgs/msg/Vector3"]
    return store.types["geometry_msgs/msg/Wrench"](vector(0.0, 0.0, 0.0), vector(0.0, 0.0, torque))


def bag_of(path: Path, messages: Sequence[tuple[float, str, Any]]) -> Path:
    """A bag of ROS 2 with these messages: arrival [s since 1970], topic and message."""
    with Writer2(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topics: dict[str, Any] = {}
        for at, topic, message in sorted(messages, key=lambda each: each[0]):
            kind = message.__msgtype__
            if topic not in topics:
                topics[topic] = writer.add_connection(topic, kind, typestore=ROS2)
            writer.write(topics[topic], round(1e9 * at), ROS2.serialize_cdr(message, kind))
    return path


def dive_bag(
    folder: Path,
    form: str = "mcap",
    arrival: Array = EPOCH + DIVE.time,
    stamps: Array = EPOCH + DIVE.time,
    *,
    late: float = 0.0,
    short: range = range(0),
) -> Path:
    """The dive as a bag of ROS 1, or of ROS 2 in SQLite or MCAP; its wrench bears no stamp.

    Args:
        arrival: (n,) when the messages arrive [s since 1970].
        stamps: (n,) of the Imu [s].
        late: By how much the wrench arrives after the Imu [s].
        short: Imus of which the bag has 20 bytes.
    """
    one = form == "ros1"
    store, path = (ROS1, folder / "dive.bag") if one else (ROS2, folder / "bag")
    serialize = ROS1.serialize_ros1 if one else ROS2.serialize_cdr
    writer = Writer1(path) if one else Writer2(path, version=9, storage_plugin=StoragePlugin[form.upper()])
    with writer:
        turns = writer.add_connection("/imu/data", IMU, typestore=store)
        pushes = writer.add_connection("/thrust", WRENCH, typestore=store)
        for k, (rate, torque) in enumerate(zip(DIVE.rate, DIVE.torque, strict=True)):
            payload = bytes(serialize(imu(store, float(stamps[k]), rate), IMU))
            writer.write(turns, round(1e9 * float(arrival[k])), payload[:20] if k in short else payload)
            writer.write(pushes, round(1e9 * float(arrival[k] + late)), serialize(wrench(store, torque), WRENCH))
    return path


@pytest.mark.parametrize("form", ["sqlite3", "mcap", "ros1"])
def test_bags(tmp_path: Path, form: str) -> None:
    bag = dive_bag(tmp_path, form, EPOCH + DIVE.time + 0.002, late=0.001)
    same(read(bag), EPOCH, late=0.001)
    if form != "ros1":
        inside = next(path for path in bag.iterdir() if path.suffix in (".db3", ".mcap"))
        same(read(inside), EPOCH, late=0.001)
        counts = {topic.name: (topic.type, topic.count) for topic in open_any(inside).topics}
        assert counts["/imu/data"] == (IMU, DIVE.time.size)


def whole_dive_bag(path: Path, turned: float) -> Path:
    """Odometry and wrenches of a body whose heading turns so far within the bag."""
    of, said = ROS2.types, list[tuple[float, str, Any]]()
    vector, quaternion = of["geometry_msgs/msg/Vector3"], of["geometry_msgs/msg/Quaternion"]
    for t, rate, torque in zip(DIVE.time.tolist(), DIVE.rate.tolist(), DIVE.torque.tolist(), strict=True):
        header = imu(ROS2, EPOCH + t, 0.0).header
        half = 0.5 * turned * t / float(DIVE.time[-1])
        pose = of["geometry_msgs/msg/Pose"](
            of["geometry_msgs/msg/Point"](0.0, 0.0, 0.0), quaternion(0.0, 0.0, float(np.sin(half)), float(np.cos(half)))
        )
        twist = of["geometry_msgs/msg/Twist"](vector(0.1 * torque, -0.2 * torque, 0.0), vector(0.0, 0.0, rate))
        moved = of["nav_msgs/msg/Odometry"](
            header, "base_link", of["geometry_msgs/msg/PoseWithCovariance"](pose, np.zeros(36)),
            of["geometry_msgs/msg/TwistWithCovariance"](twist, np.zeros(36)),
        )  # fmt: skip
        pushed = of["geometry_msgs/msg/Wrench"](vector(2.0 * torque, 3.0 * torque, 0.0), vector(0.0, 0.0, torque))
        said += [(EPOCH + t, "/odometry", moved)]
        said += [(EPOCH + t, "/thrust", of["geometry_msgs/msg/WrenchStamped"](header, pushed))]
    return bag_of(path, said)


def test_forces_and_headings_of_bags_are_found_where_they_move(tmp_path: Path) -> None:
    found = read(whole_dive_bag(tmp_path / "bag", turned=-2.0)).own_streams
    assert found.keys() == {"yaw_rate", "torque", "surge", "sway", "surge_force", "sway_force", "heading"}
    for name, factor in (("surge", 0.1), ("sway", -0.2), ("surge_force", 2.0), ("sway_force", 3.0)):
        np.testing.assert_allclose(found[name][1], factor * DIVE.torque)
    np.testing.assert_allclose(found["heading"][1], -2.0 * DIVE.time / DIVE.time[-1], atol=1e-9)
    still = whole_dive_bag(tmp_path / "still", turned=0.0)
    assert "heading" not in read(still).own_streams
    along = Reading(axis=AXES["sway"]).of_one(still)
    np.testing.assert_allclose(along.effort, 3.0 * DIVE.torque)


def test_a_quaternion_that_a_driver_left_empty_has_no_yaw() -> None:
    payload = struct.pack("<BBH4d", 0, 1, 0, 0.0, 0.0, 0.6, 0.8)
    assert cdr.decode(payload, cdr.QUATERNION)["yaw"] == pytest.approx(2.0 * np.arcsin(0.6))
    assert np.isnan(RosTypes("by hand").decode(struct.pack("<BBH4d", 0, 1, 0, *[0.0] * 4), cdr.QUATERNION)["yaw"])


def test_pictures_of_a_camera_are_counted_and_not_read(tmp_path: Path) -> None:
    of = ROS2.types
    header = of["std_msgs/msg/Header"](of["builtin_interfaces/msg/Time"](1, 0), "")
    picture = of["sensor_msgs/msg/CompressedImage"](header, "jpeg", np.zeros(1000, dtype=np.uint8))
    turns = [(EPOCH + k, "/imu", imu(ROS2, EPOCH + k, 0.1)) for k in range(3)]
    bag = bag_of(tmp_path / "bag", [*turns, *((EPOCH + k, "/camera", picture) for k in range(3))])
    for path in (bag, next(bag.glob("*.mcap"))):
        log = open_any(path)
        assert {topic.name: topic.count for topic in log.topics} == {"/camera": 3, "/imu": 3}
        assert [name for name, table in log.tables.items() if table.columns] == ["/imu"]


def test_a_clock_of_its_own_places_what_bears_no_stamp(tmp_path: Path) -> None:
    """A simulator stamps with its own time, while the bag goes by the wall: the wrench comes after it by that."""
    same(read(dive_bag(tmp_path, stamps=DIVE.time)), 0.0)


def test_cdr_by_hand() -> None:
    """A Wrench by the specification: four bytes of header (little endian), then six doubles."""
    payload = struct.pack("<BBH6d", 0, 1, 0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    decoded = RosTypes("by hand").decode(payload, "geometry_msgs/msg/Wrench")
    assert decoded == {"force": {"x": 1.0, "y": 2.0, "z": 3.0}, "torque": {"x": 4.0, "y": 5.0, "z": 6.0}}
    big = struct.pack(">BBH6d", 0, 0, 0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    assert RosTypes("by hand").decode(big, "geometry_msgs/msg/Wrench") == decoded


def test_recordings_of_blueos(tmp_path: Path) -> None:
    said = link.in_order(link.parameters(), link.swum(DIVE, armed_from=0.0))
    path = link.as_mcap(tmp_path / "recorder_1.mcap", said)
    recording = read(path)
    same(recording, BOOT)
    assert any("BlueROV2 Heavy" in note for note in recording.notes)
    whole = link.as_mcap(path, said, finish=False).read_bytes()  # the battery was pulled: neither an index nor an end
    path.write_bytes(whole[: len(whole) * 4 // 5])
    time, _ = read(path).streams()["yaw_rate"]
    assert 0.6 * DIVE.time.size < time.size < DIVE.time.size


def test_recordings_of_keelson(tmp_path: Path) -> None:
    """As its recorder writes them: the payload out of its envelope, with the descriptors of its type."""
    path = tmp_path / "ship.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        channels: dict[str, int] = {}

        def put(subject: str, at: float, message: Any) -> None:
            message.timestamp.FromNanoseconds(round(1e9 * at))
            received, enclosed, payload = keelson.uncover(keelson.enclose(message.SerializeToString()))
            key = keelson.construct_pubsub_key("sea", "ship", subject, "imu")
            if key not in channels:
                name = keelson.get_subject_schema(subject)
                described = keelson.get_protobuf_file_descriptor_set_from_type_name(name).SerializeToString()
                schema = writer.register_schema(name, "protobuf", described)
                channels[key] = writer.register_channel(key, "protobuf", schema)
            assert abs(received * 1e-9 - clock.time()) < 60.0  # the recorder's clock has nothing to do with the stamps
            writer.add_message(channels[key], round(1e9 * (at + 0.1)), payload, enclosed)

        for t, rate, torque in zip(DIVE.time, DIVE.rate, DIVE.torque, strict=True):
            put("yaw_rate_degps", EPOCH + t, TimestampedFloat(value=np.degrees(rate)))
            put("vehicle_armed", EPOCH + t, TimestampedBool(value=True))
            put("propeller_rate_rpm", EPOCH + t, TimestampedFloat(value=100.0 * torque))
        writer.finish()  # type: ignore[no-untyped-call]
    with pytest.raises(BadInput, match="Keelson sends no torque: it is computed from the propellers and the rudder"):
        read(path)
    key = keelson.construct_pubsub_key("sea", "ship", "propeller_rate_rpm", "imu")
    same(read(path, f"torque={key}.value*0.01"), EPOCH)


def test_our_own_keys(tmp_path: Path) -> None:
    path = tmp_path / "leng.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        channels = {name: writer.register_channel(f"leng/yaw/{name}", "json", 0) for name in ("rate", "torque")}
        for t, rate, torque in zip(DIVE.time, DIVE.rate, DIVE.torque, strict=True):
            for name, value in (("rate", rate), ("torque", torque)):
                data = json.dumps({"t": BOOT + t, "value": value}).encode()
                writer.add_message(channels[name], round(1e9 * (EPOCH + t)), data, 0)
        writer.finish()  # type: ignore[no-untyped-call]
    same(read(path), BOOT)
