"""Learners of the axes of one body in one process, over a real bus: each is told what velocities the others hear."""

from __future__ import annotations

import json
import queue
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import zenoh

from incsvr.compensation.freeing import takes_torque
from incsvr.plant.axes import AXES
from incsvr.plant.body import CORIOLIS, DECLARED_INERTIA
from incsvr.signals import synchronise
from service import wire
from service.bus.session import free_endpoint, listener_config_at, open_session
from service.cli.command_line import main
from service.host.host import Host
from service.host.worker_threads import WorkerThreads
from service.recordings.recording import Recording
from service.recordings.recording_csv import write
from tests.service.conftest import PATIENCE, Bench, StartBench, configured
from tests.whole_vehicle import LINEAR, MASS, PLACES, QUADRATIC, whole_vehicle

AXES_HERE = ("surge", "sway", "yaw")
BATCH = 40
COMMON = {
    "vehicle__name": "rov",
    "vehicle__rate_limit": 5.0,
    "vehicle__rate_range": (-1.0, 1.0),
    "vehicle__mass_matrix": MASS.tolist(),
    "learner__batch": BATCH,
    "learner__epsilon": 0.5,
    "signals__torque": "measured",
}
THREE = {
    **COMMON,
    "prefix": "rov/yaw",
    "learners": {
        axis: {"vehicle": {"axis": axis}, "signals": {"channels": channels}}
        for axis, channels in (
            ("yaw", ["surge", "sway"]),
            ("surge", ["sway", "body_yaw_rate"]),
            ("sway", ["surge", "body_yaw_rate"]),
        )
    },
}


@pytest.fixture(scope="module")
def run() -> Recording:
    return whole_vehicle(910_000, 3000)


def send(bench: Bench, run: Recording, axes: tuple[str, ...]) -> None:
    """Five seconds of each stream in a message, of one axis after the other, and more once all has come: samples wait
    for ten."""
    for start in np.arange(0.0, float(run.time[-1]), 5.0).tolist():
        part = (run.time >= start) & (run.time < start + 5.0)
        t = tuple(run.time[part].tolist())
        for axis in axes:
            keys = wire.Keys(f"rov/{axis}")
            for stream, name in ((keys.torque, AXES[axis].effort), (keys.rate, AXES[axis].rate)):
                payload = wire.measurement(t, tuple(run.columns[name][part].tolist()))
                bench.session.put(stream, payload, congestion_control=zenoh.CongestionControl.BLOCK)
        heard(bench, [f"rov/{axis}" for axis in axes], int(np.count_nonzero(run.time < start + 5.0)))


def heard(bench: Bench, prefixes: list[str], count: int) -> None:
    """Returns once these learners have heard so many values of their yaw rate."""
    until = time.monotonic() + PATIENCE
    for host in bench.hosts:
        while host.keys.prefix in prefixes:
            streams = host.watch.report(host.node).streams
            if streams["yaw_rate"].received >= count:
                break
            assert time.monotonic() < until, f"{host.keys.prefix} does not hear what is sent: {streams}"
            time.sleep(0.002)


def reports(bench: Bench, axis: str) -> queue.Queue[wire.IterationReport]:
    return bench.follow(f"rov/{axis}/iteration", wire.IterationReport)


def test_three_axes_hear_each_other_and_learn_each_its_own_damping(start: StartBench, run: Recording) -> None:
    bench = start(**THREE)
    published = {axis: reports(bench, axis) for axis in AXES_HERE}
    send(bench, run, AXES_HERE)
    for k, axis in enumerate(AXES_HERE):
        host = next(each for each in bench.hosts if each.keys.prefix == f"rov/{axis}")
        learner = host.node.config
        streams = replace(run, axis=AXES[axis]).streams()
        settings, coupled = learner.signal_settings(), learner.coupled()
        assert coupled is not None
        assert coupled.inertia == learner.vehicle.inertia == MASS[PLACES[k]]
        wanted = {name: streams[name] for name in ("yaw_rate", "torque", *settings.channels)}
        samples, _ = synchronise(settings, wanted, takes_torque(settings, None, coupled))
        batch = published[axis].get(timeout=PATIENCE).batch
        assert list(batch.damping) == samples.damping[:BATCH].tolist()
        assert set(batch.parts) == {DECLARED_INERTIA, CORIOLIS}
        assert np.std(batch.parts[CORIOLIS]) > 0.1 * np.std(np.sum(list(batch.parts.values()), axis=0))
        last = len(samples) // BATCH - 1
        for _ in range(last):
            report = published[axis].get(timeout=PATIENCE)
        rate = np.linspace(*(host.node.served.model.trained_range or (0.0, 0.0)), 21)
        true = LINEAR[k] * rate + QUADRATIC[k] * rate * np.abs(rate)
        wrong = host.node.served.model.predict(rate).damping - true
        assert np.sqrt(np.mean(wrong**2)) < 0.06 * np.max(np.abs(true))
        ledger, _ = bench.get(host.keys.effects)
        assert ledger is not None
        split = wire.decode(wire.EffectsLedger, ledger).batch
        assert split is not None
        assert split.parts.keys() == report.batch.parts.keys()


@pytest.mark.slow
def test_a_recording_of_the_whole_vehicle_is_replayed_to_all_axes(tmp_path: Path) -> None:
    run, endpoint = whole_vehicle(910_001, 500), free_endpoint()
    write(tmp_path / "whole.csv", run)
    (tmp_path / "config.yaml").write_text(json.dumps(configured(**THREE).model_dump(mode="json", exclude_unset=True)))
    words = ["--config", str(tmp_path / "config.yaml"), "--connect", endpoint, "--speed", "50"]
    learners = configured(**THREE).each()
    with open_session(listener_config_at(endpoint)) as server:
        hosts = [Host(server, each, len(learners)) for each in learners]
        with WorkerThreads(hosts):
            assert main(["replay", str(tmp_path / "whole.csv"), *words]) == 0
        for host in hosts:
            assert host.node.batches.samples_seen > 35
            assert {stream.received for stream in host.watch.report(host.node).streams.values()} == {500}
