"""Several candidates for one quantity, and several senders under one name."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag1 import Writer as Writer1
from scipy.signal import lfilter

from incsvr.errors import BadInput
from incsvr.numerics import Array
from service.inputs.input_mapper import InputMapper
from service.inputs.senders import alternates
from service.inputs.settings import Inputs
from tests.service import link
from tests.service.logs.dive import BOOT, EPOCH, dive, read
from tests.service.logs.test_middleware import IMU, ROS1, ROS2, WRENCH, bag_of, imu, wrench

DIVE = dive(seconds=20.0)
Messages = list[tuple[float, str, Any]]
NOISE = 0.003 * np.random.default_rng(650_000).standard_normal(DIVE.time.size)


def turning(topic: str, rate: Array, late: float = 0.0, axis: str = "z", mark: float = 0.0) -> Messages:
    found = []
    for at, value in zip((EPOCH + DIVE.time + late).tolist(), rate.tolist(), strict=True):
        message = imu(ROS2, at, 0.0)
        setattr(message.angular_velocity, axis, value)
        message.angular_velocity_covariance = np.array([mark, *[0.0] * 8])
        found.append((at, topic, message))
    return found


def pushing(topic: str, torque: Array, late: float = 0.001) -> Messages:
    times = (EPOCH + DIVE.time + late).tolist()
    return [(at, topic, wrench(ROS2, value)) for at, value in zip(times, torque.tolist(), strict=True)]


OURS = [*turning("/imu/data", DIVE.rate), *pushing("/thrust", DIVE.torque)]


@pytest.mark.parametrize(
    "beside",
    [
        turning("/ahrs/imu", np.full(DIVE.time.size, np.nan)),
        turning("/ahrs/imu", np.zeros(DIVE.time.size), mark=-1.0),
        turning("/ahrs/imu", NOISE),
        turning("/ahrs/imu", DIVE.rate[::-1], mark=-1.0),
        pushing("/allocated", np.zeros(DIVE.time.size)),
    ],
    ids=["no number", "zeros, marked", "noise", "marked", "a torque of zeros"],
)
def test_a_source_that_moves_comes_before_a_name(tmp_path: Path, beside: Messages) -> None:
    streams = read(bag_of(tmp_path / "bag", [*OURS, *beside])).streams()
    np.testing.assert_allclose(streams["yaw_rate"][1], DIVE.rate)
    np.testing.assert_allclose(streams["torque"][1], DIVE.torque)


def test_a_mark_alone_refuses_nothing(tmp_path: Path) -> None:
    bag = bag_of(tmp_path / "bag", [*turning("/imu/data", DIVE.rate, mark=-1.0), *OURS[DIVE.time.size :]])
    np.testing.assert_allclose(read(bag).streams()["yaw_rate"][1], DIVE.rate)


@pytest.mark.parametrize("still", [np.zeros(DIVE.time.size), NOISE], ids=["zero", "noise"])
def test_an_imu_on_its_side_is_refused_with_the_axis_that_turns(tmp_path: Path, still: Array) -> None:
    both = turning("/imu/data", still)
    for (_, _, message), rate in zip(both, DIVE.rate.tolist(), strict=True):
        message.angular_velocity.y = rate
    bag = bag_of(tmp_path / "bag", [*both, *OURS[DIVE.time.size :]])
    with pytest.raises(BadInput) as caught:
        read(bag)
    cure = str(caught.value).rpartition("--column ")[2]
    assert cure == "yaw_rate=/imu/data.angular_velocity.y:rad/s"
    np.testing.assert_allclose(read(bag, cure).streams()["yaw_rate"][1], DIVE.rate)


@pytest.mark.parametrize("header", ["time,yaw_rate,gyro_z,tau", "t,yaw_rate,gyro_z,torque"])
@pytest.mark.parametrize("dead", ["0", "", "0.25"])
def test_a_dead_column_yields_to_a_living_one(tmp_path: Path, header: str, dead: str) -> None:
    lines = [header]
    lines += [f"{t},{dead},{r},{u}" for t, r, u in zip(DIVE.time, DIVE.rate, DIVE.torque, strict=True)]
    (tmp_path / "run.csv").write_text("\n".join(lines), encoding="utf-8")
    np.testing.assert_allclose(read(tmp_path / "run.csv").columns["yaw_rate"], DIVE.rate)


def test_marks_of_no_measurement_are_no_second_sender(tmp_path: Path) -> None:
    marked = DIVE.rate.copy()
    marked[7::40] = 99.99
    lines = [f"{t},{r},{u}" for t, r, u in zip(DIVE.time, marked, DIVE.torque, strict=True)]
    (tmp_path / "run.csv").write_text("\n".join(["time,gyro_z,tau", *lines]), encoding="utf-8")
    rate = read(tmp_path / "run.csv").streams()["yaw_rate"][1]
    np.testing.assert_allclose(rate, np.delete(DIVE.rate, np.s_[7::40]))


@pytest.mark.parametrize(
    ("second", "name"),
    [
        (pushing("/thrust", np.zeros(DIVE.time.size), 0.02), "torque"),
        (pushing("/thrust", np.zeros(DIVE.time.size), 0.02)[::10], "torque"),
        (pushing("/thrust", 2.0 * np.sin(0.3 * DIVE.time), 0.02)[::2], "torque"),
        (turning("/imu/data", NOISE, 0.02), "yaw_rate"),
        (turning("/imu/data", -DIVE.rate, 0.02), "yaw_rate"),
    ],
    ids=["zeros", "zeros at 2 Hz", "a second controller", "a gimbal", "a gyro upside down"],
)
def test_two_senders_under_one_name_are_refused(tmp_path: Path, second: Messages, name: str) -> None:
    with pytest.raises(BadInput, match=f"{name} alternates between two series of values"):
        read(bag_of(tmp_path / "bag", [*OURS, *second]))


def test_two_senders_that_a_bag_names(tmp_path: Path) -> None:
    """Values that jump about: no series, but the connections tell."""
    rng = np.random.default_rng(650_001)
    with Writer1(tmp_path / "dive.bag") as writer:
        turns = writer.add_connection("/imu/data", IMU, typestore=ROS1)
        pushes = [writer.add_connection("/thrust", WRENCH, typestore=ROS1, callerid=each) for each in ("/a", "/b")]
        for at, rate, torque in zip((EPOCH + DIVE.time).tolist(), DIVE.rate, DIVE.torque, strict=True):
            writer.write(turns, round(1e9 * at), ROS1.serialize_ros1(imu(ROS1, at, rate), IMU))
            for k, value in enumerate((torque, rng.uniform(-3.0, 3.0))):
                payload = ROS1.serialize_ros1(wrench(ROS1, value), WRENCH)
                writer.write(pushes[k], round(1e9 * at) + 1 + k, payload)
    with pytest.raises(BadInput, match=r"comes by turns from two senders on /thrust, which the log names, 50 %"):
        read(tmp_path / "dive.bag")


@pytest.mark.parametrize("boot", [BOOT, BOOT + 500.0], ids=["one clock", "a clock of its own"])
def test_a_gimbal_that_speaks_as_the_autopilot(tmp_path: Path, boot: float) -> None:
    said = link.in_order(link.parameters(), link.swum(DIVE, armed_from=0.0))
    gimbal = [
        replace(link.attitude(t + 0.02, rate, boot), at=t + 0.02) for t, rate in zip(DIVE.time, NOISE, strict=True)
    ]
    with pytest.raises(BadInput, match="two senders"):
        read(link.as_tlog(tmp_path / "dive.tlog", link.in_order(said, gimbal)))


def test_two_senders_on_the_bus_are_doubted() -> None:
    mapper = InputMapper(Inputs.model_validate({
        "yaw_rate": {"topic": "imu", "field": "z"}, "torque": {"topic": "thrust", "field": "z"},
    }))  # fmt: skip
    for at, rate, torque in zip(DIVE.time.tolist(), DIVE.rate, DIVE.torque, strict=True):
        mapper.take([("imu", b'{"z": %f}' % rate, at), ("thrust", b'{"z": %f}' % torque, at + 0.001)])
    assert not [doubt for doubt in mapper.notices() if "two senders" in doubt]
    for at, rate, torque in zip((20.0 + DIVE.time).tolist(), DIVE.rate, DIVE.torque, strict=True):
        mapper.take([("imu", b'{"z": %f}' % rate, at), ("thrust", b'{"z": %f}' % torque, at + 0.001)])
        mapper.take([("thrust", b'{"z": 0.0}', at + 0.02)])
    assert any("torque alternates between two series" in doubt for doubt in mapper.notices())


@pytest.mark.parametrize("pace", [0.4, 1.0])
def test_a_torque_of_a_simulators_clock_beside_a_rate_without_is_doubted(pace: float) -> None:
    mapper = InputMapper(Inputs.model_validate({
        "yaw_rate": {"topic": "imu", "field": "z"}, "torque": {"topic": "thrust", "field": "z", "stamp": "t"},
    }))  # fmt: skip
    for k, at in enumerate((EPOCH + DIVE.time[:100]).tolist()):
        mapper.take([("imu", b'{"z": 0.%d}' % (k % 7), at), ("thrust", b'{"t": %f, "z": 1}' % (k * 0.05 * pace), at)])
    doubts = " ".join(mapper.notices())
    assert "the stamps of torque are of another clock" in doubts
    assert ("run at 0.4 times the speed of the arrivals" in doubts) == (pace != 1.0)


def test_spikes_noise_and_a_command_to_and_fro_are_one_series() -> None:
    rng = np.random.default_rng(650_002)
    spiked = DIVE.rate.copy()
    spiked[rng.choice(spiked.size, 20, replace=False)] += rng.uniform(-3.0, 3.0, 20)
    to_and_fro = 6.0 * (-1.0) ** np.arange(DIVE.time.size)
    for values in (DIVE.rate, DIVE.torque, spiked, DIVE.torque + rng.standard_normal(spiked.size), to_and_fro):
        assert alternates(np.asarray(values, dtype=np.float64)) is None


TIME = 0.05 * np.arange(1200, dtype=np.float64)
LEVELS = np.repeat(
    np.random.default_rng(650_003).uniform(-6.0, 6.0, 75), np.random.default_rng(650_004).integers(16, 48, 75)
)[: TIME.size]
WAVES = 3.0 * np.sin(0.5 * TIME) + np.sin(1.1 * TIME)


@pytest.mark.parametrize("values", [2, 5, 8])
@pytest.mark.parametrize("second", [np.zeros(TIME.size), 2.0 * np.cos(0.3 * TIME) + 1.0], ids=["zeros", "a controller"])
@pytest.mark.parametrize("first", [WAVES, WAVES + 0.03 * np.sin(31.0 * TIME**2)], ids=["clean", "noise"])
def test_senders_by_turns_of_several_values(first: Array, second: Array, values: int) -> None:
    turn = (np.arange(TIME.size) // values) % 2 == 0
    assert alternates(np.where(turn, first, second)) == pytest.approx(0.5, abs=0.3)


@pytest.mark.parametrize("values", [5, 8])
def test_senders_by_turns_of_commands_that_hold(values: int) -> None:
    turn = (np.arange(TIME.size) // values) % 2 == 0
    assert alternates(np.where(turn, LEVELS, 0.0)) == pytest.approx(0.5, abs=0.3)


@pytest.mark.parametrize("values", range(3, 11))
@pytest.mark.parametrize("noise", [0.0, 0.02, 0.1])
def test_pulses_are_of_one_sender(values: int, noise: float) -> None:
    """Pulses have one size, drawn sizes, or sizes that go slowly; a rate follows them, as it is and in levels."""
    rng, pulse = np.random.default_rng(650_005), np.arange(TIME.size) // values
    told = noise * rng.standard_normal(TIME.size)
    for size in (np.ones(TIME.size), rng.uniform(0.3, 1.0, 601)[pulse], 1.0 + 0.6 * np.sin(0.15 * pulse)):
        for low in (-1.0, 0.0, 0.3):
            pushed = size * np.where(pulse % 2 == 0, 1.0, low) + told
            rate = np.asarray(lfilter([0.0, 0.5], [1.0, -0.5], pushed))
            for series in (pushed, rate, np.round(rate / 0.05) * 0.05):
                assert alternates(series) is None
