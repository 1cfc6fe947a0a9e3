"""The learners of a vehicle file on one bus: each stream comes once and reaches all that wait for it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmarks.service.six_axes import vehicle_of
from service import wire
from service.config.vehicle_file import write_vehicle
from simulator.six_degrees import BODIES
from tests.service.conftest import Bench, StartBench

BOAT = vehicle_of(BODIES["boat"](np.random.default_rng(81)), (1.0, 0.4, 0.0, 0.0, 0.0, 0.5))


def started(start: StartBench, folder: Path) -> Bench:
    write_vehicle(folder / "boat.yaml", BOAT)
    return start(vehicle__file=str(folder / "boat.yaml"), prefix="boat")


def test_a_channel_that_comes_to_the_first_learner_reaches_the_others(start: StartBench, tmp_path: Path) -> None:
    bench = started(start, tmp_path)
    yaw, surge = bench.hosts
    bench.session.put("boat/yaw/channel/sway", wire.measurement((1.0, 1.1), (0.1, 0.2)))
    bench.session.put("boat/surge/rate", wire.measurement((1.0, 1.1), (0.5, 0.6)))
    bench.health_when(lambda health: {"sway", "surge"} <= health.streams.keys())
    assert {name: yaw.watch.report(yaw.node).streams[name].value for name in ("sway", "surge")} == {
        "sway": 0.2,
        "surge": 0.6,
    }
    streams = surge.watch.report(surge.node).streams
    assert (streams["sway"].value, streams["sway"].received, streams["yaw_rate"].value) == (0.2, 2, 0.6)
