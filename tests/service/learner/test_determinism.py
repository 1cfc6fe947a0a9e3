"""Time comes from the data alone: played at any speed or read from a file, the same recording gives the same bytes."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
import zenoh

from incsvr.signals import synchronise
from service import wire
from service.learner.node import LearnerNode
from service.recordings import samples_from_recording
from service.recordings.recording import Recording, from_table
from simulator import leng
from tests.faults import with_faults
from tests.service.conftest import PATIENCE, StartBench, configured

#: A quick grid, so that four seconds of the vehicle's time, played at its own pace, give several iterations.
QUICK: dict[str, Any] = {
    "signals__sample_period": 0.05,
    "signals__smoothing": 0.03,
    "signals__gap": 0.06,
    "signals__lateness": 0.05,
    "learner__batch": 12,
}
ITERATIONS = 5
BLOCK = zenoh.CongestionControl.BLOCK


@pytest.fixture(scope="module")
def recording() -> Recording:
    run = leng.recording("T1", seed=11)
    part = (run.time >= 60.0) & (run.time < 64.0)
    return from_table(run.name, run.time[part] - 60.0, {n: v[part] for n, v in run.columns.items()})


def without_boot(snapshot: wire.ModelSnapshot) -> bytes:
    return json.dumps(json.loads(wire.encode(snapshot)) | {"boot": ""}).encode()


@pytest.fixture(scope="module")
def from_file(recording: Recording) -> list[bytes]:
    """The snapshots of a learner without a bus that is handed the whole streams at once."""
    node = LearnerNode(configured(**QUICK), boot="")
    for name, (t, value) in recording.streams().items():
        node.push(name, t, value)
    snapshots = []
    while (outcome := node.learn()) is not None:
        snapshots.append(without_boot(outcome.served))
    assert len(snapshots) >= ITERATIONS
    return snapshots


@pytest.mark.parametrize("speed", [pytest.param(1.0, marks=pytest.mark.slow), 50.0, 1e6])
def test_played_at_any_speed_it_gives_the_same_bytes(
    start: StartBench, recording: Recording, from_file: list[bytes], speed: float
) -> None:
    bench = start(**QUICK)
    models = bench.follow(bench.keys.model, wire.ModelSnapshot)
    bench.play(recording, speed)
    assert [without_boot(models.get(timeout=PATIENCE)) for _ in from_file] == from_file


def test_messages_out_of_order_and_twice_give_the_same_bytes(
    start: StartBench, recording: Recording, from_file: list[bytes]
) -> None:
    bench = start(**QUICK)
    models = bench.follow(bench.keys.model, wire.ModelSnapshot)
    bench.play(with_faults(recording.streams(), 2, jitter=0.04, duplicates=0.1))
    assert [without_boot(models.get(timeout=PATIENCE)) for _ in from_file] == from_file


def test_the_loop_over_recordings_gives_the_same_models(recording: Recording, from_file: list[bytes]) -> None:
    """`incsvr fit` runs this loop."""
    config = configured(**QUICK)
    samples, _ = synchronise(config.signal_settings(), recording.streams())
    for expected, iteration in zip(
        from_file, samples_from_recording.learn(samples, config.learner_settings()), strict=True
    ):
        snapshot = wire.decode(wire.ModelSnapshot, expected)
        assert snapshot.iteration == iteration.number
        assert snapshot.support.rate == tuple(iteration.model.support_rate)
        assert snapshot.support.weight == tuple(iteration.model.weight)
        assert snapshot.noise == iteration.model.sigma


def test_messages_that_carry_arrays_give_the_same_bytes(
    start: StartBench, recording: Recording, from_file: list[bytes]
) -> None:
    bench = start(**QUICK)
    models = bench.follow(bench.keys.model, wire.ModelSnapshot)
    for name, (t, value) in recording.streams().items():
        for part in np.array_split(np.arange(t.size), 7):
            payload = wire.measurement(tuple(t[part].tolist()), tuple(value[part].tolist()))
            bench.session.put(bench.keys.stream(name), payload, congestion_control=BLOCK)
    assert [without_boot(models.get(timeout=PATIENCE)) for _ in from_file] == from_file
