"""A learner on the bus of ROS 2: keys of rmw_zenoh and of zenoh-bridge-ros2dds, bytes that rosbags serialises."""

from __future__ import annotations

import queue
from typing import Any

import numpy as np
import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from zenoh.ext import Int64, z_deserialize

from incsvr.errors import BadInput
from service.inputs.bus_keys import matches
from service.inputs.input_mapper import InputMapper
from service.inputs.owners import ros_type
from service.inputs.settings import Inputs
from tests.service.conftest import PATIENCE
from tests.service.inputs.conftest import Board
from tests.service.inputs.test_forms import MAVROS
from tests.service.logs.dive import EPOCH, Dive, dive

STORE: Any = get_typestore(Stores.ROS2_JAZZY)
for name, text in MAVROS.items():
    STORE.register(get_types_from_msg(text, name))
HASH = "RIHS01_7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b"


@pytest.fixture(scope="module")
def swim() -> Dive:
    return dive(90.0, 20.0)


def rmw(topic: str, kind: str, hashed: str = HASH) -> str:
    package, _, name = kind.partition("/msg/")
    return f"0/{topic}/{package}::msg::dds_::{name}_/{hashed}"


def cdr(kind: str, **fields: Any) -> bytes:
    return bytes(STORE.serialize_cdr(STORE.types[kind](**fields), kind))


def header(t: float) -> Any:
    at = round(1e9 * (EPOCH + t))
    stamp = STORE.types["builtin_interfaces/msg/Time"](at // 10**9, at % 10**9)
    return STORE.types["std_msgs/msg/Header"](stamp, "base_link")


def vector(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Any:
    return STORE.types["geometry_msgs/msg/Vector3"](x, y, z)


def imu(t: float, rate: float) -> bytes:
    still, none = STORE.types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0), np.zeros(9)
    fields = {"orientation": still, "orientation_covariance": none, "angular_velocity": vector(z=rate)}
    fields |= {"angular_velocity_covariance": none, "linear_acceleration": vector(z=9.8)}
    return cdr("sensor_msgs/msg/Imu", header=header(t), **fields, linear_acceleration_covariance=none)


def wrench(torque: float) -> bytes:
    return cdr("geometry_msgs/msg/Wrench", force=vector(), torque=vector(z=torque))


def wrench_stamped(t: float, torque: float) -> bytes:
    inner = STORE.types["geometry_msgs/msg/Wrench"](vector(), vector(z=torque))
    return cdr("geometry_msgs/msg/WrenchStamped", header=header(t), wrench=inner)


DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
IMU, WRENCH, STAMPED = "sensor_msgs/msg/Imu", "geometry_msgs/msg/Wrench", "geometry_msgs/msg/WrenchStamped"


@pytest.mark.parametrize("hashed", [HASH, "TypeHashNotSupported"])
def test_yaw_is_learned_from_imu_and_wrench_of_rmw_zenoh(board: Board, swim: Dive, hashed: str) -> None:
    """The wrench bears no stamp: it is placed by when it arrives, here between two samples of the Imu."""
    vessel = board({"preset": "ros2"})
    messages = []
    for t, rate, torque in zip(swim.time, swim.rate, swim.torque, strict=True):
        messages += [(rmw("nucleo/imu", IMU, hashed), imu(t, rate)), (rmw("thrust", WRENCH, hashed), wrench(torque))]
    vessel.send(messages, swim.time.size, "application/octet-stream")
    vessel.health_when(lambda health: "roll_rate" in health.streams)  # health may be asked between two of one message
    vessel.health_when(lambda health: health.streams["roll_rate"].received == swim.time.size)
    vessel.health_when(lambda health: health.iteration >= 8)
    assert vessel.off() < 0.4


def test_and_from_what_a_bridge_announces(board: Board, swim: Dive) -> None:
    """The keys of zenoh-bridge-ros2dds say no type: its liveliness tokens do; what is not read is left alone."""
    vessel = board({"preset": "ros2"})
    kinds = {"rov/imu": IMU, "rov/wrench": STAMPED, "rov/camera": "sensor_msgs/msg/Image"}
    spelt = [(key.replace("/", "§"), kind.replace("/", "§")) for key, kind in kinds.items()]
    tell = vessel.session.liveliness().declare_token
    tokens = [tell(f"@/1a2b3c/@ros2_lv/MP/{key}/{kind}/:::,,") for key, kind in spelt]
    mapped = vessel.host.mapped
    assert mapped is not None
    vessel.health_when(lambda _: len(mapped.mapper.types) == 2)
    messages = []
    for t, rate, torque in zip(swim.time[:400], swim.rate, swim.torque, strict=False):
        messages += [("rov/imu", imu(t, rate)), ("rov/wrench", wrench_stamped(t, torque)), ("rov/camera", b"\0" * 64)]
    health = vessel.send(messages, 400, "application/octet-stream")
    assert vessel.health_when(lambda health: health.counters["samples"] >= 40).counters["rejected"] == 0
    assert health.streams["torque"].t == pytest.approx(EPOCH + swim.time[399], abs=1e-3)
    del tokens


@pytest.mark.parametrize("bridge", [False, True])
def test_health_goes_out_as_diagnostics(board: Board, swim: Dive, bridge: bool) -> None:
    """As rmw_zenoh wants it: type hash, attachment and tokens; over a bridge the topic alone. rosbags reads it."""
    inputs: dict[str, Any] = {"preset": "ros2"}
    key = f"0/diagnostics/diagnostic_msgs::msg::dds_::DiagnosticArray_/{STORE.hash_rihs01(DIAGNOSTICS)}"
    rate_key = rmw("imu", IMU)
    if bridge:
        key, rate_key = "diagnostics", "rov/imu"
        inputs["yaw_rate"] = {"topic": "rov/imu", "form": f"cdr:{IMU}"}
    vessel = board(inputs, health={"stale_after": 0.2})
    came: queue.Queue[Any] = queue.Queue()
    vessel.session.declare_subscriber(key, came.put)
    vessel.send([(rate_key, imu(t, rate)) for t, rate in zip(swim.time[:20], swim.rate, strict=False)], 20)
    samples = [came.get(timeout=PATIENCE)]
    while (message := STORE.deserialize_cdr(samples[-1].payload.to_bytes(), DIAGNOSTICS)).status[0].level == 0:
        samples.append(came.get(timeout=PATIENCE))  # until it is late that no torque has come
    (status,) = message.status
    assert (status.name, status.level, status.hardware_id) == ("incsvr: leng/yaw", 3, "leng")
    assert {each.key: each.value for each in status.values}["learning"] == "learning"
    assert "no torque has arrived yet" in {status.message, *(each.value for each in status.values)}
    if bridge:
        assert samples[-1].attachment is None
        return
    number, at, gid = z_deserialize(tuple[Int64, Int64, bytes], samples[-1].attachment)
    assert (number, len(gid)) == (len(samples), 16)
    assert abs(at - 1e9 * message.header.stamp.sec) < 1e9
    tokens = {str(reply.ok.key_expr) for reply in vessel.session.liveliness().get("@ros2_lv/0/**") if reply.ok}
    session = str(vessel.host._session.info.zid())
    assert tokens == {
        f"@ros2_lv/0/{session}/0/0/NN/%/%/incsvr_leng_yaw",
        f"@ros2_lv/0/{session}/0/1/MP/%/%/incsvr_leng_yaw/%diagnostics/{key.partition('diagnostics/')[2]}/::,10:,:,:,,",
    }


def test_broken_messages_are_counted_and_learn_nothing(board: Board, swim: Dive) -> None:
    vessel = board({"preset": "ros2"})
    whole = imu(0.0, 0.5)
    broken = [(rmw("imu", IMU), payload) for payload in (b"", b"\0\1", whole[:100], b"\7" * 300)]
    vessel.send([*broken, (rmw("imu", IMU), whole)], 1, "application/octet-stream")
    health = vessel.health_when(lambda health: health.counters.get("rejected:undecodable", 0) == 4)
    assert any("4 values rejected: undecodable" in reason for reason in health.reasons)


def test_what_has_come_for_a_while_stays() -> None:
    """A preset would rather have the Imu than a vector; of the two vectors the first by its name is taken."""
    hearing, kind = InputMapper(Inputs(preset="ros2")), "geometry_msgs/msg/Vector3Stamped"
    for k in range(60):
        for topic in ("turn", "gyro"):
            hearing.take([(rmw(topic, kind), cdr(kind, header=header(0.1 * k), vector=vector(z=0.1)), 0.1 * k)])
    assert "yaw_rate" not in hearing.take([(rmw("imu", IMU), imu(6.0, 0.5), 6.0)])
    heard = hearing.take([(rmw("gyro", kind), cdr(kind, header=header(6.0), vector=vector(z=0.2)), 6.0)])
    assert {name: each.value for name, each in heard.items()} == {"yaw_rate": 0.2}
    early = InputMapper(Inputs(preset="ros2"))
    early.take([(rmw("compass", kind), cdr(kind, header=header(0.0), vector=vector(z=0.1)), 0.0)])
    assert early.take([(rmw("imu", IMU), imu(0.1, 0.5), 0.1)])["yaw_rate"].value == 0.5
    assert any(f"{rmw('compass', kind)} is ignored" in note for note in early.notes)


def test_a_rate_that_never_changes_is_told_with_one_that_does() -> None:
    still, turns = rmw("a/imu", "sensor_msgs/msg/Imu"), rmw("z/imu", "sensor_msgs/msg/Imu")
    mapper = InputMapper(Inputs(preset="ros2"))
    for k in range(60):
        mapper.take([(still, imu(0.05 * k, 0.0), 0.05 * k), (turns, imu(0.05 * k, 0.01 * k), 0.05 * k)])
        told = [notice for notice in mapper.notices() if "never changes" in notice]
        assert bool(told) == (k >= 49)
    assert told == [f"yaw_rate from {still} never changes, but {turns} does: name it in inputs.yaw_rate"]


def test_keys_and_topics() -> None:
    assert ros_type(rmw("a/b", IMU)) == IMU
    assert ros_type("a/b/sensor_msgs::msg::dds_::Imu_/x") is None
    for key in ("nucleo/imu", rmw("nucleo/imu", IMU)):
        assert matches("/nucleo/imu", key, "ros2")
        assert not matches("/imu", key, "ros2")
    with pytest.raises(BadInput, match=r"inputs.yaw_rate: '/a//b' is no key expression"):
        InputMapper(Inputs.model_validate({"yaw_rate": {"topic": "/a//b"}}))
    with pytest.raises(BadInput, match="px4 is a preset of logs; on a bus use ros2"):
        InputMapper(Inputs(preset="px4"))
