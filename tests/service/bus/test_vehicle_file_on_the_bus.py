"""The learners of a vehicle file on one bus: each stream comes once and reaches all that wait for it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from service import wire
from service.cli.command_line import main
from service.cli.output import WIDTH
from service.config.vehicle_file import learners_in, write_vehicle
from simulator.vehicles import BODIES
from tests.service.conftest import Bench, StartBench
from tests.vehicle_of_body import vehicle_of

BOAT = vehicle_of(BODIES["boat"](np.random.default_rng(81)), (1.0, 0.4, 0.0, 0.0, 0.0, 0.5))


def started(start: StartBench, folder: Path, **settings: Any) -> Bench:
    write_vehicle(folder / "boat.yaml", BOAT)
    return start(learners=learners_in(folder / "boat.yaml"), prefix="boat", health__stale_after=1000.0, **settings)


def test_a_channel_that_comes_to_the_first_learner_reaches_the_others(start: StartBench, tmp_path: Path) -> None:
    bench = started(start, tmp_path)
    yaw, surge = bench.hosts
    bench.session.put("boat/yaw/channel/sway", wire.measurement((1.0, 1.1), (0.1, 0.2)))
    bench.session.put("boat/surge/rate", wire.measurement((1.0, 1.1), (0.5, 0.6)))
    bench.health_when(lambda health: {"sway", "surge"} <= {n for n, s in health.streams.items() if s.value is not None})
    assert {name: yaw.watch.report(yaw.node).streams[name].value for name in ("sway", "surge")} == {
        "sway": 0.2,
        "surge": 0.6,
    }
    streams = surge.watch.report(surge.node).streams
    assert (streams["sway"].value, streams["sway"].received, streams["yaw_rate"].value) == (0.2, 2, 0.6)


IMU = {"form": "json", "topic": "boat/imu", "stamp": "t"}
MAPPED = {
    "inputs__yaw_rate": {**IMU, "field": "gyro[2]", "unit": "deg/s"},
    "inputs__channels": {"surge": {**IMU, "field": "v[0]"}, "sway": {**IMU, "field": "v[1]"}},
    "inputs__armed": {"form": "json", "topic": "boat/armed", "field": "on"},
    "inputs__thrusters": {
        "topic": "boat/thrust",
        "command": "N",
        "stamp": "t",
        "form": "json",
        "each": [
            {"field": "port", "position": [-0.5, -0.3, 0.0], "pushes": [1.0, 0.0, 0.0]},
            {"field": "starboard", "position": [-0.5, 0.3, 0.0], "pushes": [1.0, 0.0, 0.0]},
        ],
    },
}
"""The boat as others speak: one message holds all velocities, another one the thrust of both thrusters [N]."""


def test_one_message_of_a_mapping_reaches_all_axes(start: StartBench, tmp_path: Path) -> None:
    bench = started(start, tmp_path, **MAPPED)
    yaw, surge = bench.hosts
    assert yaw.mapped is not None
    assert surge.mapped is None  # one learner reads each message for all
    assert yaw.further == ("surge",)
    bench.session.put("boat/armed", json.dumps({"on": 0}))
    bench.session.put("boat/imu", json.dumps({"t": 1.0, "gyro": [0.0, 0.0, 90.0], "v": [0.5, 0.1]}))
    bench.health_when(lambda health: health.streams["yaw_rate"].received == 1)
    bench.session.put("boat/thrust", json.dumps({"t": 1.0, "port": 30.0, "starboard": 10.0}))
    bench.health_when(lambda health: health.streams["torque"].received == 1)
    first, second = (host.watch.report(host.node).streams for host in bench.hosts)
    assert first["torque"].value == pytest.approx(0.3 * 30.0 - 0.3 * 10.0)
    assert (first["surge"].value, "surge_force" in first) == (0.5, False)
    assert (second["yaw_rate"].value, second["torque"].value, second["sway"].value) == (0.5, 40.0, 0.1)
    assert second["body_yaw_rate"].value == pytest.approx(np.pi / 2.0)
    assert not yaw.node.batches.readings["surge"].held
    assert not surge.node.batches.readings["yaw_rate"].held  # nothing is learned from before it is armed
    replace(bench, keys=surge.keys).health_when(lambda health: health.learning.state == "paused")
    bench.session.put("boat/armed", json.dumps({"on": 1}))
    for k in range(20):
        bench.session.put("boat/imu", json.dumps({"t": 1.1 + 0.1 * k, "gyro": [0.0, 0.0, 9.0 * k], "v": [0.5, 0.1]}))
    bench.health_when(lambda health: health.streams["yaw_rate"].received == 21)
    assert surge.node.batches.readings["yaw_rate"].newest == pytest.approx(3.0)


def test_status_shows_the_vehicle_and_the_axis_that_the_prefix_names(
    start: StartBench, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bench = started(start, tmp_path)
    bench.session.put("boat/surge/rate", wire.measurement((1.0, 1.1), (0.5, 0.6)))
    bench.health_when(lambda health: health.streams["surge"].received == 2)
    words = ["status", "--connect", bench.endpoint, "--prefix", "boat/surge", "--json", str(tmp_path / "status.json")]
    assert main(words) == 0
    shown = capsys.readouterr().out
    lines = shown.splitlines()
    assert max(map(len, lines)) <= WIDTH
    assert [line.split()[0] for line in lines[:4]] == ["rov", "axis", "yaw", "surge"]
    assert "0.6 m/s" in lines[3]
    assert "surge velocity" in shown.partition("boat/surge")[2]
    told = json.loads((tmp_path / "status.json").read_text(encoding="utf-8"))
    assert told["axes"].keys() == {"yaw", "surge"}
    assert told["axes"]["surge"]["health"]["streams"]["yaw_rate"]["value"] == 0.6
    assert told["health"]["axes"] == {"yaw": "boat/yaw", "surge": "boat/surge"}
