"""A log and a bus make the same streams of the same messages, in every format, however many messages come at once.

The messages are those of a vehicle beside which others speak: a second bank of outputs and a second battery, a second
vehicle with parameters of its own that is never armed, and motor directions that change under way.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag2 import Writer as Bag

from service.inputs.input_mapper import InputMapper, Message
from service.inputs.settings import Inputs
from tests.service import link
from tests.service.inputs.test_ros2 import IMU, STAMPED, STORE, cdr, header, imu, rmw, wrench_stamped
from tests.service.logs.dive import BOOT, EPOCH, Dive, dive, read

SWIM = dive(60.0, 20.0)
ARMED_FROM, CHANGED = 5.0, 30.0
"""When the pilot arms, and when the directions of motors 1 and 2 change [s]."""
STATE = "mavros_msgs/msg/State"


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


def ros() -> Iterator[tuple[float, str, str, bytes]]:
    """The same dive as ROS tells it, with a camera's Imu and another vehicle beside: arrival [s], topic, type, data."""
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


FILES: dict[str, tuple[float, Callable[[Path], Path]]] = {
    "BIN": (BOOT, lambda folder: link.as_dataflash(folder / "dive.BIN", said(), gyros=2)),
    "mcap": (BOOT, lambda folder: link.as_mcap(folder / "recorder.mcap", said())),
    "bag": (EPOCH, lambda folder: bag(folder / "bag")),
}
BUSES: dict[str, tuple[float, Callable[[], list[Message]]]] = {
    "blueos": (BOOT, lambda: [(*link.as_key(each), each.at) for each in said()]),
    "ros2": (EPOCH, lambda: [(rmw(topic, kind), payload, at) for at, topic, kind, payload in ros()]),
}
"""What the vehicle's clock shows at first [s], and what is written or published."""


@pytest.mark.parametrize("form", FILES)
def test_a_log_makes_the_streams_of_its_vehicle(form: str, tmp_path: Path) -> None:
    begin, write = FILES[form]
    same(read(write(tmp_path)).streams(), begin)


@pytest.mark.parametrize("at_once", [1, 7, 100_000])
@pytest.mark.parametrize("preset", BUSES)
def test_a_bus_makes_the_same(preset: str, at_once: int) -> None:
    (begin, messages), mapper = BUSES[preset], InputMapper(Inputs.model_validate({"preset": preset}))
    parts: dict[str, list[Any]] = {"yaw_rate": [], "torque": []}
    coming = iter(messages())
    while some := list(islice(coming, at_once)):
        for name, values in mapper.take(some).items():
            parts.get(name, []).append((values.t[values.learnable], values.value[values.learnable]))
    same({name: tuple(map(np.concatenate, zip(*each, strict=True))) for name, each in parts.items()}, begin)


def same(streams: Mapping[str, Any], begin: float) -> None:
    """The streams are those of the dive while the vehicle is armed."""
    armed = SWIM.time >= ARMED_FROM
    for name, values, error in (("yaw_rate", SWIM.rate, 1e-6), ("torque", SWIM.torque, 1e-4)):
        np.testing.assert_allclose(streams[name][0], begin + SWIM.time[armed], atol=1e-3)
        np.testing.assert_allclose(streams[name][1], values[armed], atol=error)
