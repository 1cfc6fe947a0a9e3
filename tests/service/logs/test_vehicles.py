"""Logs of autopilots: bytes by pymavlink's packers, and by hand from the formats' specifications."""

from __future__ import annotations

import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from incsvr.errors import BadInput
from service.logs import open_any
from service.recordings.recording import Recording
from tests.service import link
from tests.service.logs.dive import BOOT, EPOCH, Dive, dive, read

DIVE = dive()
ARMED_FROM = 5.0
"""When the pilot arms [s]."""


def same(recording: Recording, truth: Dive, begin: float, after: float = 0.0, within: float = 1e-3) -> None:
    """The streams are those of the dive, from `after` on, on a clock that showed `begin` when the log began."""
    kept = truth.time >= after
    for name, values, close in (("yaw_rate", truth.rate, 1e-6), ("torque", truth.torque, 0.02)):
        time, got = recording.streams()[name]
        np.testing.assert_allclose(time - begin, truth.time[kept], atol=within)
        np.testing.assert_allclose(got, values[kept], atol=close)


def telemetry(truth: Dive, *, boot: float = BOOT, armed_from: float = ARMED_FROM) -> list[link.Said]:
    """What a ground station writes down: the autopilot, itself and a companion, whose heartbeats have bit 128, too."""
    others = link.others(int(truth.time[-1]) + 1)
    return link.in_order(link.parameters(), link.swum(truth, armed_from=armed_from, boot=boot), others)


def test_a_telemetry_log(tmp_path: Path) -> None:
    path = link.as_tlog(tmp_path / "dive.log", telemetry(DIVE))
    counts = {topic.name: topic.count for topic in open_any(path).topics}
    assert counts["ATTITUDE"] == counts["SERVO_OUTPUT_RAW"] == DIVE.time.size
    assert counts["HEARTBEAT"] == counts["mavlink/255/190/HEARTBEAT"] == 30
    recording = read(path)
    same(recording, DIVE, BOOT, ARMED_FROM)
    assert any("frame 2 (BlueROV2 Heavy), directions -1, -1, +1, +1" in note for note in recording.notes)
    assert any("armed for 25 of 30 s" in note for note in recording.notes)


def test_only_the_autopilots_heartbeat_says_armed(tmp_path: Path) -> None:
    path = link.as_tlog(tmp_path / "dive.tlog", telemetry(DIVE, armed_from=1e9))
    with pytest.raises(BadInput, match="the vehicle was never armed, so there is nothing to learn from"):
        read(path)


def test_a_stamp_of_32_bits_runs_over_and_a_vehicle_starts_anew(tmp_path: Path) -> None:
    late = 2.0**32 * 1e-6 + 100.0  # servos' µs ran over 100 s ago, and do so never again here
    same(read(link.as_tlog(tmp_path / "late.tlog", telemetry(DIVE, boot=late))), DIVE, late, ARMED_FROM)
    close = 2.0**32 * 1e-6 - 15.0  # and here in the midst of it
    same(read(link.as_tlog(tmp_path / "close.tlog", telemetry(DIVE, boot=close))), DIVE, close, ARMED_FROM)
    second = [replace(each, at=each.at + 100.0) for each in telemetry(DIVE, boot=20.0)]
    both = read(link.as_tlog(tmp_path / "twice.tlog", [*telemetry(DIVE), *second]))
    time, _ = both.streams()["yaw_rate"]
    assert (np.diff(time) > 0.0).all()
    assert time[-1] - BOOT == pytest.approx(100.0 + DIVE.time[-1], abs=0.05)


def test_a_dataflash_log(tmp_path: Path) -> None:
    said = link.in_order(link.parameters(), link.swum(DIVE))
    path = link.as_dataflash(tmp_path / "00000012.BIN", said, gyros=2)
    counts = {topic.name: topic.count for topic in open_any(path).topics}
    assert counts["IMU"] == counts["IMU[1]"] == counts["RCOU"] == DIVE.time.size
    same(read(path), DIVE, BOOT, ARMED_FROM)
    other = read(path, "yaw_rate=IMU[1].GyrZ")
    np.testing.assert_allclose(other.streams()["yaw_rate"][1], DIVE.rate[DIVE.time >= ARMED_FROM] + 0.5, atol=1e-6)
    idle = link.swum(Dive(DIVE.time, DIVE.rate, 0.01 * DIVE.command))
    with pytest.raises(BadInput, match="never armed"):
        read(link.as_dataflash(tmp_path / "deck.BIN", link.in_order(link.parameters(), idle), events=False))


def ulog(truth: Dive) -> bytes:
    """A PX4 log by its specification: header, flags, formats, subscriptions, data."""
    content = bytearray(b"ULog\x01\x12\x35\x01" + struct.pack("<Q", round(1e6 * BOOT)))

    def message(kind: bytes, payload: bytes) -> None:
        content.extend(struct.pack("<H", len(payload)) + kind + payload)

    message(b"B", bytes(40))
    message(b"F", b"vehicle_angular_velocity:uint64_t timestamp;float[3] xyz;")
    message(b"F", b"vehicle_torque_setpoint:uint64_t timestamp;float[3] xyz;")
    message(b"F", b"actuator_armed:uint64_t timestamp;bool armed;")
    for number, name in enumerate((b"vehicle_angular_velocity", b"vehicle_torque_setpoint", b"actuator_armed")):
        message(b"A", struct.pack("<BH", 0, number) + name)
    for t, rate, torque in zip(truth.time, truth.rate, truth.torque, strict=True):
        stamp = round(1e6 * (BOOT + t))
        message(b"D", struct.pack("<HQ3f", 0, stamp, 0.0, 0.0, rate))
        message(b"D", struct.pack("<HQ3f", 1, stamp, 0.0, 0.0, torque / 12.0))
        if round(100 * t) % 100 == 0:
            message(b"D", struct.pack("<HQ?", 2, stamp, t >= ARMED_FROM))
    return bytes(content)


def test_a_px4_log(tmp_path: Path) -> None:
    path = tmp_path / "dive.ulg"
    path.write_bytes(ulog(DIVE))
    with pytest.raises(BadInput, match="the torque is a fraction of full thrust, not N m, until its scale is given"):
        read(path)
    same(read(path, "torque=vehicle_torque_setpoint.xyz[2]*12"), DIVE, BOOT, ARMED_FROM)
    path.write_bytes(ulog(Dive(DIVE.time, 0.01 * np.random.default_rng(780002).normal(size=600), DIVE.command)))
    with pytest.raises(BadInput, match=r"the yaw rate never exceeds its noise .* fraction of full thrust"):
        read(path)


@pytest.mark.parametrize(
    "begin", [b"\xa3\x95\x80", b"ULog\x01\x12\x35\x01", b"\x89MCAP0\r\n", b"PAR1", b"#ROSBAG V2.0\n"]
)
def test_a_damaged_log_is_one_sentence(tmp_path: Path, begin: bytes) -> None:
    path = tmp_path / "broken.log"
    path.write_bytes(begin + bytes(range(256)) * 4)
    with pytest.raises(BadInput) as caught:
        read(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("set_at", [None, 20.0])
def test_a_log_of_a_station_whose_clock_was_not_set_is_read(tmp_path: Path, set_at: float | None) -> None:
    """Its stamps begin in 1970; the vehicle's own clock carries the streams where the station's is set on the way."""
    said = telemetry(DIVE)
    moved = [each if set_at is None or each.at < set_at else replace(each, at=each.at + EPOCH) for each in said]
    expected = read(link.as_tlog(tmp_path / "set.tlog", said)).streams()
    found = read(link.as_tlog(tmp_path / "1970.tlog", moved, begin=3.0)).streams()
    for name in ("yaw_rate", "torque"):
        np.testing.assert_allclose(found[name], expected[name], atol=1e-6)
