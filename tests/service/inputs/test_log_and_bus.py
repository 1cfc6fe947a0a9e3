"""The reader of logs and the bus make the same samples from the same messages, in every format.

The messages are those of a vehicle beside which others speak: a second bank of outputs and a second battery, a second
vehicle with parameters of its own that is never armed, and motor directions that change under way.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag2 import Writer as Bag

from incsvr.signals import synchronise
from incsvr.signals.samples import Samples
from service.inputs.settings import Inputs
from service.logs.reading import LogDescription
from service.recordings.reading import Reading
from tests.service import link
from tests.service.inputs.conftest import Board, Vessel, configured
from tests.service.inputs.test_ros2 import IMU, STAMPED, STORE, cdr, header, imu, rmw, wrench_stamped
from tests.service.logs.dive import BOOT, EPOCH, Dive, dive

_SWUM = dive(60.0, 20.0)
SWIM = Dive(_SWUM.time + 0.013, _SWUM.rate, _SWUM.command)
"""No stamp is at the edge of a cell of the samples' grid, where the last bit of a clock would decide."""
ARMED_FROM, CHANGED = 5.0, 30.0
"""When the pilot arms, and when the directions of motors 1 and 2 change [s]."""
STATE = "mavros_msgs/msg/State"
Message = tuple[float, str, str, bytes]
"""Arrival [s], ROS topic, type, payload."""


def said() -> list[link.Said]:
    """Everything on the link, in the order of arrival."""
    late = SWIM.time >= CHANGED
    before, after = (link.pulses(SWIM, (side, side, 1, 1)) for side in (1, -1))
    told = np.where(late[:, None], after, before)
    changes = [link.parameter(CHANGED - 0.001, f"MOT_{motor}_DIRECTION", -1.0) for motor in (1, 2)]
    bank = [link.outputs(t, (1100, 1900, 1500, 1500), port=1) for t in SWIM.time]
    spare = [link.battery(t + 0.001, 12.0, which=1) for t in range(60)]
    mirrored = Dive(SWIM.time, -SWIM.rate, -SWIM.command)
    other = [*link.parameters(FRAME_CONFIG=1.0, MOT_3_DIRECTION=-1.0), *link.swum(mirrored, armed_from=1e9)]
    return link.in_order(
        link.parameters(MOT_1_DIRECTION=1.0, MOT_2_DIRECTION=1.0),
        link.swum(SWIM, told, ARMED_FROM),
        changes,
        bank,
        spare,
        link.of(2, other),
    )


def ros() -> Iterator[Message]:
    """The same dive as ROS tells it, with a camera's Imu and another vehicle beside."""
    state = {"connected": True, "guided": False, "manual_input": True, "mode": "MANUAL", "system_status": 4}
    for k, (t, rate, torque) in enumerate(zip(SWIM.time, SWIM.rate, SWIM.torque, strict=True)):
        for rov, sign, armed in (("rov2", 1.0, t >= ARMED_FROM), ("rov1", -1.0, False)):
            if k % 20 == 0:
                yield t, f"{rov}/mavros/state", STATE, cdr(STATE, header=header(t), armed=armed, **state)
            yield t + 0.001, f"{rov}/zed/imu", IMU, imu(t, 1.0)
            yield t + 0.002, f"{rov}/imu/data", IMU, imu(t, sign * rate)
            yield t + 0.003, f"{rov}/thrust", STAMPED, wrench_stamped(t, sign * torque)


def bag(path: Path) -> Path:
    with Bag(path, version=9) as writer:
        lines: dict[str, Any] = {}
        for at, topic, kind, payload in ros():
            if topic not in lines:
                lines[topic] = writer.add_connection(f"/{topic}", kind, typestore=STORE)
            writer.write(lines[topic], round(1e9 * (EPOCH + at)), payload)
    return path


FILES: dict[str, Callable[[Path], Path]] = {
    "BIN": lambda folder: link.as_dataflash(folder / "dive.BIN", said(), gyros=2),
    "mcap": lambda folder: link.as_mcap(folder / "recorder.mcap", said()),
    "bag": lambda folder: bag(folder / "bag"),
}
BUSES: dict[str, tuple[float, str, Callable[[], list[tuple[str, bytes]]]]] = {
    "blueos": (BOOT, "mavlink/1/1/ATTITUDE", lambda: link.as_keys(said())),
    "ros2": (EPOCH, "rov2/imu/data", lambda: [(rmw(topic, kind), payload) for _, topic, kind, payload in ros()]),
}
"""What the clock shows at first, the key on which the yaw rate comes, and what is published."""


def truth(begin: float) -> Samples:
    """The samples of the streams themselves while the vehicle is armed, on a clock that showed `begin` at first [s]."""
    armed = SWIM.time >= ARMED_FROM
    time = begin + SWIM.time[armed]
    streams = {"yaw_rate": (time, SWIM.rate[armed]), "torque": (time, SWIM.torque[armed])}
    return synchronise(configured({"preset": "blueos"}).signal_settings(), streams)[0]


def same(samples: Samples, begin: float, fewest: int) -> None:
    wanted, count = truth(begin), len(samples)
    assert count >= fewest
    np.testing.assert_allclose(samples.time, wanted.time[:count])
    np.testing.assert_allclose(samples.yaw_rate, wanted.yaw_rate[:count], atol=1e-6)
    np.testing.assert_allclose(samples.damping, wanted.damping[:count], atol=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("form", FILES)
def test_a_log_makes_the_samples_of_its_vehicle(form: str, tmp_path: Path) -> None:
    recording = Reading(LogDescription((), Inputs())).of_one(FILES[form](tmp_path))
    samples, _ = synchronise(configured({"preset": "blueos"}).signal_settings(), recording.streams())
    same(samples, EPOCH if "bag" in form else BOOT, 130)


@pytest.mark.parametrize("preset", BUSES)
def test_a_bus_makes_the_same(preset: str, board: Board) -> None:
    vessel = board({"preset": preset})
    taken = learned(vessel)
    begin, ours, messages = BUSES[preset]
    published = messages()
    vessel.send(published, sum(ours in key for key, _ in published))
    vessel.health_when(lambda health: sum(map(len, taken)) == 25 * health.iteration >= 125)
    same(Samples.concatenate(taken), begin, 125)


def learned(vessel: Vessel) -> list[Samples]:
    """The batches that the learner takes, as it takes them."""
    batches, taken = vessel.host.node.batches, list[Samples]()
    whole = batches.next_batch

    def next_batch() -> Samples | None:
        batch = whole()
        taken.extend([batch] if batch is not None else [])
        return batch

    batches.next_batch = next_batch  # type: ignore[method-assign]
    return taken
