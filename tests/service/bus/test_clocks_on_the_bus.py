"""Wrong clocks on a real bus: learning goes on, or health says why it cannot, and a clean restart hears again."""

from __future__ import annotations

import signal
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import zenoh

from service import wire
from service.recordings.recording import Recording
from simulator import leng
from simulator.messages import messages
from simulator.player import play
from tests.service.commands.test_processes import (
    KEYS,
    client_after,
    endpoint,
    following,
    next_model,
    serving,
    taken_until,
)
from tests.service.conftest import PATIENCE, StartBench, teach

__all__ = ["endpoint"]


@pytest.mark.slow
@pytest.mark.parametrize("stamps", [(1e9, 1e9 + 0.02), (1e9, 1e9)])
def test_an_array_of_wrong_stamps_costs_nothing(start: StartBench, stamps: tuple[float, ...]) -> None:
    """What is learned is to the byte what is learned without them."""
    found = []
    for wrong in (True, False):
        bench = start()
        models = bench.follow(bench.keys.model, wire.ModelSnapshot)
        teach(bench.session, bench.keys, 5, 0.0, 35.0)
        if wrong:
            payload = wire.measurement(stamps, tuple(0.1 for _ in stamps))
            bench.session.put(bench.keys.rate, payload, congestion_control=zenoh.CongestionControl.BLOCK)
        teach(bench.session, bench.keys, 5, 35.0, 70.0)
        found.append([models.get(timeout=PATIENCE).model_dump(exclude={"boot"}) for _ in range(2)])
        if wrong:
            assert bench.health_when(lambda health: health.counters["rejected"] == len(stamps))
    assert found[0] == found[1]


@pytest.mark.slow
def test_clocks_that_do_not_agree_are_said_and_forgiven(start: StartBench) -> None:
    bench = start()
    run = leng.recording("T1", seed=5)
    early = run.time < 60.0
    right = messages(Recording(run.name, run.time[early], {n: v[early] for n, v in run.columns.items()}).streams())
    torque = right.stream == right.names.index("torque")
    wrong = replace(right, t=np.where(torque, right.t + 1.7e9, right.t))
    stop = threading.Event()
    player = threading.Thread(
        target=play, args=(bench.session, bench.keys, wrong), kwargs={"speed": 6.0, "stop": stop}, daemon=True
    )
    player.start()
    try:
        health = bench.health_when(lambda health: health.learning.state == "starved")
    finally:
        stop.set()
        player.join()
    assert health.learning.why.startswith("torque waits for yaw rate, whose stamps are 1700000")
    bench.play(right)
    health = bench.health_when(lambda health: health.learning.state == "learning" and health.counters["samples"] > 50)


@pytest.mark.slow
def test_a_clean_restart_hears_again(endpoint: str, tmp_path: Path) -> None:
    """The clock of the yaw rate was believed to be far ahead, and was saved like this."""
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
            teach(session, KEYS, 9, 35, 80)
            model = next_model(models)
            if model.revision == 1:
                model = next_model(models)
            assert model.revision == 2
            assert 35.0 < model.t < 80.0
