"""The learner on a real bus: what is lost, late, doubled or of another vehicle teaches nothing wrong, and is told."""

from __future__ import annotations

import signal
import time
from contextlib import suppress
from pathlib import Path
from queue import Empty

import numpy as np
import pytest
import zenoh

from service import wire
from service.bus.session import free_endpoint
from service.recordings.recording import Recording
from simulator import leng
from simulator.messages import messages
from tests.faults import with_faults
from tests.service.commands.test_processes import (
    KEYS,
    client_after,
    following,
    next_model,
    serving,
    taken_until,
)
from tests.service.conftest import PATIENCE, StartBench, cut, teach


def test_lost_messages_are_counted_by_their_numbers(start: StartBench) -> None:
    """Whatever the order in which they come, and a sender that is restarted has lost nothing by it."""
    bench = start()
    for at, number in enumerate((1, 0, 4, 6, 5, 6, 9, 8, 10, 0, 1)):
        bench.session.put(bench.keys.rate, wire.measurement(0.1 * at, 0.0, number))
    health = bench.health_when(lambda health: health.streams["yaw_rate"].received == 11)
    assert health.streams["yaw_rate"].lost == health.counters["rejected:lost"] == 3  # 2, 3 and 7


@pytest.mark.slow
def test_a_spike_that_the_filter_leaves_out_is_counted_once_with_its_stream(start: StartBench) -> None:
    """Windows of samples overlap, so that a spike is met twice; beyond a limit it is refused with the limit's name."""
    whole = cut(leng.recording("T1", seed=7), 60.0).streams()

    def spikes(**placed: tuple[float, ...]) -> dict[str, int]:
        bench = start(vehicle__torque_limit=1e7, signals__channels=["surge"])
        streams = {**whole, "surge": (whole["yaw_rate"][0], np.sin(whole["yaw_rate"][0]))}
        for name, at in placed.items():
            t, value = streams[name]
            streams[name] = t, np.where(np.isin(np.arange(t.size), np.searchsorted(t, at)), 1e6, value)
        bench.play(messages(streams))
        health = bench.health_when(lambda health: health.iteration >= 1)
        bench.stop()
        return {name: count for name, count in health.counters.items() if name.startswith(("spikes:", "rejected:"))}

    of_noise = spikes().get("spikes:torque", 0)
    placed = [0.6 * cell + 0.3 for cell in (20, 21, 40)]  # in the middle between two samples
    assert spikes(torque=tuple(placed), surge=(17.0,), yaw_rate=(33.0,)) == {
        "spikes:torque": of_noise + 3,
        "spikes:surge": 1,
        "rejected:implausible": 1,
    }


def test_drop_outs_and_disorder_teach_nothing_wrong(start: StartBench) -> None:
    """The same samples where the streams are whole, none across a drop-out, duplicates refused."""
    run = leng.recording("T1", seed=3)
    streams = cut(run, 200.0).streams()
    bench = start(learner__batch=20)
    reports = bench.follow(bench.keys.iteration, wire.IterationReport)
    what = with_faults(streams, 5, drop_outs=6.0, drop_out_length=2.0, jitter=0.15, duplicates=0.05)
    bench.play(what)
    whole = leng.samples(run)
    true = dict(zip(whole.time.tolist(), whole.damping.tolist(), strict=True))
    health = bench.health_when(lambda health: health.iteration >= 5)
    assert health.iteration < 200 / 0.6 / 20
    assert health.counters["rejected:duplicate"] > 0
    differences = []
    for _ in range(health.iteration):
        batch = reports.get(timeout=PATIENCE).batch
        differences += [abs(damping - true[t]) for t, damping in zip(batch.time, batch.damping, strict=True)]
    # Only a pause within the configured gap is bridged; beside one a sample has fewer values to go by.
    assert np.mean(np.array(differences) == 0.0) > 0.85
    assert max(differences) < 4.0  # the noise of a sample


def test_a_vehicle_whose_clock_begins_anew_is_followed(start: StartBench, run: Recording) -> None:
    bench = start()
    models = bench.follow(bench.keys.model, wire.ModelSnapshot)
    for _ in range(2):
        bench.play(run, speed=50.0)  # a busy machine follows, too
    for number in range(1, 7):
        assert models.get(timeout=PATIENCE).iteration == number
    assert bench.health().counters["rejected:clock_restarted"] == 1


def test_what_is_rejected_is_said_once_a_second_at_most(start: StartBench, caplog: pytest.LogCaptureFixture) -> None:
    bench = start()
    changes = bench.follow(bench.keys.health, wire.Health)
    began = time.monotonic()
    sent = 0
    while sent < 300:
        bench.session.put(bench.keys.rate, b"no json", congestion_control=zenoh.CongestionControl.BLOCK)
        sent += 1
        if sent % 100 == 0:  # three waves, each seen by health before the next
            while changes.get(timeout=PATIENCE).counters.get("rejected:not_json", 0) < sent:
                pass
    said = [record.getMessage() for record in caplog.records if "values rejected so far" in record.getMessage()]
    assert 1 <= len(said) <= 1 + (time.monotonic() - began)
    assert "'rejected:not_json': " in said[-1]


@pytest.mark.slow
def test_a_clean_restart_hears_again(tmp_path: Path) -> None:
    """The clock of the yaw rate was believed to be far ahead, and was saved like this."""
    endpoint = free_endpoint()
    with client_after(endpoint, tmp_path) as (process, session, alive):
        models = following(session)
        teach(session, KEYS, 9, 0, 35)
        next_model(models)
        payload = wire.measurement(tuple(1e9 + 0.02 * k for k in range(50)), (0.1,) * 50)
        session.put(KEYS.rate, payload, congestion_control=zenoh.CongestionControl.BLOCK)
        taken_until(session, 34.9)
        process.send_signal(signal.SIGTERM)
        assert process.wait(PATIENCE) == 0
        assert "DELETE" in alive.get(timeout=PATIENCE)
        with serving(endpoint, tmp_path):
            assert "PUT" in alive.get(timeout=PATIENCE)
            model: wire.ModelSnapshot | None = None
            for first in (35, 80, 125, 170):  # what is sent before the client knows of the new subscriptions is lost
                teach(session, KEYS, 9, first, first + 45)
                with suppress(Empty):
                    while model is None or model.revision == 1:
                        model = models.get(timeout=0.25 * PATIENCE)
                    break
            assert model is not None
            assert model.revision == 2
            assert model.t is not None
            assert 35.0 < model.t < 215.0
