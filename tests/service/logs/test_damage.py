"""Bags with messages that end early, files that do, and stamps that nobody set: left out, counted, said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2

from incsvr.errors import BadInput
from tests.service.logs.dive import EPOCH
from tests.service.logs.test_middleware import DIVE, ROS1, ROS2, blueos, imu, read, same, wrench

IMU, WRENCH = "sensor_msgs/msg/Imu", "geometry_msgs/msg/Wrench"
FORMS = ("sqlite3", "mcap", "ros1")


def bag(folder: Path, form: str, short: range = range(0), unset: range = range(0)) -> Path:
    """A dive as a bag, of which some Imus have 20 bytes, and some a stamp of zero."""
    one = form == "ros1"
    store, path = (ROS1, folder / "dive.bag") if one else (ROS2, folder / "bag")
    serialize = ROS1.serialize_ros1 if one else ROS2.serialize_cdr
    writer = Writer1(path) if one else Writer2(path, version=9, storage_plugin=StoragePlugin[form.upper()])
    with writer:
        turns = writer.add_connection("/imu/data", IMU, typestore=store)
        pushes = writer.add_connection("/thrust", WRENCH, typestore=store)
        for k, (t, rate, torque) in enumerate(zip(DIVE.time, DIVE.rate, DIVE.torque, strict=True)):
            arrival, stamped = round(1e9 * (EPOCH + t)), 0.0 if k in unset else EPOCH + t
            payload = bytes(serialize(imu(store, stamped, rate), IMU))
            writer.write(turns, arrival, payload[:20] if k in short else payload)
            writer.write(pushes, arrival, serialize(wrench(store, torque), WRENCH))
    return path


@pytest.mark.parametrize("form", FORMS)
def test_a_short_message_is_left_out_and_counted(tmp_path: Path, form: str) -> None:
    recording = read(bag(tmp_path, form, short=range(7, 9)))
    time, rate = recording.streams()["yaw_rate"]
    np.testing.assert_allclose(rate, np.delete(DIVE.rate, [7, 8]), atol=1e-9)
    assert time.size == DIVE.time.size - 2
    assert any(f"2 of {DIVE.time.size} messages of /imu/data cannot be read" in note for note in recording.notes)


@pytest.mark.parametrize("form", FORMS)
def test_the_first_message_may_be_the_short_one(tmp_path: Path, form: str) -> None:
    recording = read(bag(tmp_path, form, short=range(1)))
    assert recording.streams()["yaw_rate"][0].size == DIVE.time.size - 1


@pytest.mark.parametrize("form", FORMS)
def test_a_bag_of_which_most_cannot_be_read_is_refused_in_a_sentence(tmp_path: Path, form: str) -> None:
    with pytest.raises(BadInput, match=r"messages of /imu/data cannot be read .*: record again"):
        read(bag(tmp_path, form, short=range(1, DIVE.time.size)))


def test_a_file_that_ends_early_says_where(tmp_path: Path) -> None:
    whole = blueos()
    half = tmp_path / "half.mcap"
    half.write_bytes(whole[: len(whole) // 2])
    recording = read(half)
    time = recording.streams()["yaw_rate"][0]
    lasted = time[-1] - time[0]
    (said,) = [note for note in recording.notes if "ends early" in note]
    after = float(said.split("ends early, ")[1].split(" s ")[0])
    assert after == pytest.approx(lasted, abs=0.3)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("unset", [range(5), range(3, 150, 10), range(DIVE.time.size)], ids=["first", "some", "all"])
def test_a_stamp_of_zero_is_none(tmp_path: Path, form: str, unset: range) -> None:
    recording = read(bag(tmp_path, form, unset=unset))
    same(recording, EPOCH)
    said = [note for note in recording.notes if "messages of yaw_rate bear no stamp" in note]
    assert bool(said) == (len(unset) < DIVE.time.size)
