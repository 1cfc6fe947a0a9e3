"""Logs whose clocks were set under way, and messages that come late, twice or with a wrong stamp."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.numerics import Array
from service.inputs.clocks import Clock
from service.inputs.live_clock import LiveClock
from service.recordings.recording import Recording
from tests.service import link
from tests.service.logs.dive import BOOT, EPOCH, dive, read
from tests.service.logs.test_middleware import DIVE, ROS2, bag_of, dive_bag, imu, wrench
from tests.service.logs.test_whose import DIVE as SWUM
from tests.service.logs.test_whose import written

HALF = 4.0
"""When a clock is set [s]."""
LATE = 5.0
"""By how much a second link is late [s]."""


def follows(recording: Recording, within: float = 1e-5) -> None:
    """Every value of the dive stands once, at the time that has gone by since its beginning."""
    for name, wanted in (("yaw_rate", DIVE.rate), ("torque", DIVE.torque)):
        time, values = recording.streams()[name]
        np.testing.assert_allclose(values, wanted, atol=1e-6)
        np.testing.assert_allclose(time - time[0], DIVE.time, atol=within)


def set_clock(time: Array) -> Array:
    """Times of which those before `HALF` are of a clock that began in 1970 [s since 1970]."""
    return np.where(time < HALF, 100.0, EPOCH) + time


@pytest.mark.parametrize("stamps", ["set with it", "since boot", "set alone"])
def test_a_log_whose_clock_is_set_goes_on(tmp_path: Path, stamps: str) -> None:
    aware, boot = EPOCH + DIVE.time, 50.0 + DIVE.time
    arrival = aware if stamps == "set alone" else set_clock(DIVE.time)
    recording = read(dive_bag(tmp_path, "mcap", arrival, boot if stamps == "since boot" else set_clock(DIVE.time)))
    period = float(np.median(np.diff(DIVE.time)))
    follows(recording, within=0.01 * period)
    said = [note for note in recording.notes if "the clock of the log was set at" in note]
    assert len(said) == (stamps != "set alone")


def test_a_clock_that_is_set_to_and_fro_leaves_the_vehicle_its_own() -> None:
    between = (DIVE.time > HALF) & (DIVE.time < 2.0 * HALF)
    arrival, stamps = 100.0 + DIVE.time + np.where(between, EPOCH, 0.0), 50.0 + DIVE.time
    clock = Clock.of(arrival, stamps)
    for late in (0.0, 0.001):
        time, own = clock.times_of(arrival + late, stamps)
        assert own
        np.testing.assert_array_equal(time, stamps)


def test_a_log_without_stamps_whose_clock_is_set_goes_on(tmp_path: Path) -> None:
    recording = read(dive_bag(tmp_path, "mcap", set_clock(DIVE.time), np.zeros(DIVE.time.size)))
    follows(recording)


def test_a_csv_whose_clock_is_set_goes_on(tmp_path: Path) -> None:
    rows = np.c_[set_clock(DIVE.time), DIVE.rate, DIVE.torque]
    path = tmp_path / "dive.csv"
    np.savetxt(path, rows, delimiter=",", header="t,yaw_rate,torque", comments="", fmt="%.9f")
    follows(read(path))


def test_one_stamp_far_from_the_clock_gives_way_to_its_arrival(tmp_path: Path) -> None:
    stamps = EPOCH + DIVE.time
    stamps[[20, 41]] = EPOCH + 3e8, EPOCH - 4e6
    follows(read(dive_bag(tmp_path, "mcap", EPOCH + DIVE.time, stamps)))


@pytest.mark.parametrize("form", ["tlog", "mcap"])
def test_messages_that_come_again_over_a_second_link_count_once(tmp_path: Path, form: str) -> None:
    first = link.in_order(link.parameters(), link.swum(SWUM, armed_from=0.0))
    again = [replace(each, at=each.at + LATE) for each in first if each.message.get_type() != "PARAM_VALUE"]
    twice = read(written(tmp_path, form, first, again)).streams()
    (tmp_path / "once").mkdir()
    once = read(written(tmp_path / "once", form, first)).streams()
    for name in ("yaw_rate", "torque"):
        for one, other in zip(once[name], twice[name], strict=True):
            np.testing.assert_allclose(other, one, atol=1e-6)


def test_what_came_late_after_an_outage_stands_where_it_was_measured(tmp_path: Path) -> None:
    first = link.in_order(link.parameters(), link.swum(SWUM, armed_from=0.0))
    late = [replace(each, at=12.0) if 8.0 < each.at < 12.0 else each for each in first]
    held_up = read(written(tmp_path, "tlog", late)).streams()["yaw_rate"]
    np.testing.assert_allclose(held_up[0] - BOOT, SWUM.time, atol=1e-3)
    np.testing.assert_allclose(held_up[1], SWUM.rate, atol=1e-6)


def test_a_simulation_at_half_the_pace_keeps_its_own_time() -> None:
    time: Array = np.arange(0.0, 60.0, 0.02, dtype=np.float64)
    clock = Clock.of(EPOCH + 2.0 * time, time)
    others: Array = np.asarray(time[::5] + 0.001, dtype=np.float64)
    np.testing.assert_allclose(clock.times_of(EPOCH + 2.0 * others, others)[0], others)
    np.testing.assert_allclose(clock.times_of(EPOCH + 2.0 * others, None)[0], others, atol=0.25)


PACED = dive(seconds=40.0)


def paced_bag(path: Path, arrival: Array, torque_stamps: Array | None = None, rate_stamps: Array = PACED.time) -> Path:
    """The dive as a bag of ROS 2 whose Imu bears the stamps of a simulator, or none where they are zero."""
    types = ROS2.types
    messages = []
    for k, (at, rate, torque) in enumerate(zip(arrival.tolist(), PACED.rate, PACED.torque, strict=True)):
        turned, pushed = imu(ROS2, float(rate_stamps[k]), rate), wrench(ROS2, torque)
        if torque_stamps is not None:
            header = imu(ROS2, float(torque_stamps[k]), 0.0).header
            pushed = types["geometry_msgs/msg/WrenchStamped"](header, pushed)
        messages += [(at, "/imu/data", turned), (at + 1e-6, "/thrust", pushed)]
    return bag_of(path, messages)


@pytest.mark.parametrize("speed", [0.5, 0.33, 1.6, "wavering"])
@pytest.mark.parametrize("stamped", [False, True])
def test_a_simulator_at_another_speed_places_what_bears_no_stamp_of_it(
    tmp_path: Path, speed: float | str, stamped: bool
) -> None:
    of_each = 0.6 + 0.2 * np.sin(0.4 * PACED.time) if speed == "wavering" else np.full(PACED.time.size, speed)
    arrival = EPOCH + np.cumsum(np.diff(PACED.time, prepend=0.0) / of_each.astype(float))
    recording = read(paced_bag(tmp_path / "bag", arrival, arrival if stamped else None))
    time, torque = recording.streams()["torque"]
    np.testing.assert_allclose(torque, PACED.torque, atol=1e-9)
    np.testing.assert_allclose(time, PACED.time, atol=0.05 if speed == "wavering" else 0.001)
    assert any("times the speed of the arrivals" in note for note in recording.notes)


@pytest.mark.parametrize("stamps", [np.zeros(PACED.time.size), EPOCH + 2.0 * PACED.time], ids=["no", "the wall's"])
def test_a_rate_without_a_simulator_s_stamps_is_refused(tmp_path: Path, stamps: Array) -> None:
    bag = paced_bag(tmp_path / "bag", EPOCH + 2.0 * PACED.time, PACED.time, stamps)
    with pytest.raises(BadInput, match=r"yaw_rate bears .*, and those of torque run at 0.5 times the speed"):
        read(bag)


def test_a_simulator_at_half_speed_on_the_bus() -> None:
    count: Array = np.arange(100.0, dtype=np.float64)
    clock, _, _ = LiveClock().take("yaw_rate", count, EPOCH + 0.1 * count, 0.05 * count)
    clock, times, own = clock.take("torque", count, EPOCH + 0.1 * count + 0.08, None)
    assert times[-1] == pytest.approx(0.05 * 99 + 0.04)
    assert not own
    assert "runs at 0.5 times the speed" in clock.doubts("torque", own, False)[0]
