"""Thrust that is lost under way, on the bus: an event and a notice of health, the same however it is played."""

from __future__ import annotations

import queue
from functools import cache
from typing import Any

import numpy as np
import pytest

from incsvr.forecasting.thrust_watch import ThrustChange
from service import wire
from service.config.configuration import Config
from service.config.sources import read
from service.fitting.scaled import scaled_config
from service.learner.node import LearnerNode
from service.recordings.reading import RATE_LIMIT
from service.recordings.recording import Recording
from service.recordings.samples_from_recording import learner_for, samples_of, signals_for
from simulator.mission import Mission
from simulator.physics import Physics
from simulator.vehicles import TURNING
from simulator.world import play
from tests.service.conftest import PATIENCE, StartBench

ONSET_S, BACK_S, END_S = 300.0, 450.0, 560.0


@cache
def mission() -> tuple[Recording, float]:
    """An AUV under rate control whose thrust is halved for a while, and its inertia [kg m²]."""
    weak = Physics(thrust=(lambda t: np.where((t >= ONSET_S) & (t < BACK_S), 0.5, 1.0),))
    outcome = play(Mission(TURNING["auv"], "rate_control", 12, duration=END_S, besides=weak))
    return outcome.recording, outcome.inertia


@cache
def config() -> Config:
    recording, inertia = mission()
    signals = signals_for([recording], inertia, RATE_LIMIT)
    samples, _ = samples_of(recording, signals, None)
    return scaled_config(read(None, {"state": None}), recording, signals, learner_for(samples))


def played(node: LearnerNode, chunk_s: float, begin: float, end: float) -> list[ThrustChange]:
    """What a learner finds of the mission between two times [s], so much of each stream at once."""
    found = []
    while begin < end:
        for name in ("yaw_rate", "torque"):
            t, value = mission()[0].streams()[name]
            here = (t >= begin) & (t < min(begin + chunk_s, end))
            node.push(name, t[here], value[here])
        while node.learn() is not None:
            pass
        begin += chunk_s
        assert node.thrust is not None
        found += node.thrust.take()
    return found


@pytest.mark.slow
def test_what_is_found_follows_from_the_data_and_not_from_how_they_come() -> None:
    """And after a restart the thrust that is lost is still lost."""
    node = LearnerNode(config(), boot="")
    (lost,) = played(node, 2.0, 0.0, 440.0)
    again = LearnerNode(config(), boot="", memory=node.memory())
    assert again.thrust is not None
    assert again.thrust.state.level == lost.level[0]
    (back,) = played(node, 2.0, 440.0, END_S)
    assert (lost.is_back, back.is_back) == (False, True)
    assert lost.seen - ONSET_S <= 60.0
    assert lost.since == pytest.approx(ONSET_S, abs=10.0)
    assert played(LearnerNode(config(), boot=""), 7.3, 0.0, END_S) == [lost, back]


def settings() -> dict[str, Any]:
    """The sections of the configuration in which it is another than the default."""
    known = config()
    return {name: getattr(known, name).model_dump(exclude_defaults=True) for name in ("vehicle", "signals", "learner")}


@pytest.mark.slow
def test_it_is_an_event_on_the_bus_and_health_tells_it(start: StartBench) -> None:
    bench = start(**settings())
    events: queue.Queue[wire.ThrustEvent] = bench.follow(bench.keys.event, wire.ThrustEvent)
    bench.play(mission()[0])
    lost, back = events.get(timeout=PATIENCE), events.get(timeout=PATIENCE)
    assert (lost.event, back.event, lost.axis) == ("thrust lost", "thrust back", "yaw")
    assert lost.size_low < 0.5 < lost.size_high
    assert lost.thrust == pytest.approx(1.0 - lost.size)
    assert lost.revision is not None
    assert f"since {lost.since:.1f} s yaw thrust is lost" in lost.why
    health = bench.health_when(lambda health: back.why in health.reasons)
    assert lost.why not in health.reasons
