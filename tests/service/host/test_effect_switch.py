"""The learner changes over to traced effects as a whole or not at all: what goes wrong on the way changes nothing."""

from __future__ import annotations

import json
import os
import queue
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.model.rows import Factor
from incsvr.tracing.model import TracedModel
from service import wire
from service.bus.session import client_config_at, free_endpoint, listener_config_at, open_session
from service.config.traced_effects import TracedEffects, effects_from_trace
from service.host.host import Host
from service.learner.next_iteration import NextIteration
from service.learner.node import LearnerNode
from service.live.tracing_state import TraceContent, TracingState
from service.recordings.recording import Recording, from_table
from service.state.store import Store
from simulator import leng
from tests.hidden import acting, recording, with_channels, write_trace
from tests.service.config.test_traced_effects import part
from tests.service.conftest import PATIENCE, configured
from tests.service.live.test_live_tracing import tracing

LIVE: dict[str, Any] = {
    "signals__channels": ["sway"],
    "tracing__live": True,
    "tracing__window": 240.0,
    "tracing__proof": 90.0,
}
PROVEN_UNTIL = 260.0
"""The proof sees the vehicle's time until then [s]; afterwards the sensor of the sway fails."""


@pytest.fixture(scope="module")
def failing() -> Recording:
    """The vehicle with a hidden lag; its sensor of the sway says 0, and once something that is no sway."""
    run = recording(3, 360.0)
    sway = np.zeros(run.time.size)
    sway[np.searchsorted(run.time, PROVEN_UNTIL + 10.0)] = 1e100
    return with_channels(run, {"sway": sway})


@pytest.fixture
def found(tmp_path: Path) -> dict[str, Any]:
    """The trace of that vehicle, with a coupling to the sway, which the proof cannot refuse: there is none in it."""
    path = tmp_path / "trace.json"
    write_trace(path)
    trace: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    model = TracedModel.from_dict(trace["model"])
    pushed = acting("coupling:sway", Factor("value", "sway"), value=-8.0)
    return trace | {"model": replace(model, effects=(*model.effects, pushed)).to_dict()}


def effects(found: dict[str, Any]) -> TracedEffects:
    return effects_from_trace(found["model"], found["effects"], leng.INERTIA, ("sway",), "a test")


def pushed(nodes: list[LearnerNode], run: Recording) -> None:
    for name, (t, value) in run.streams().items():
        for node in nodes:
            node.push(name, t, value)


def learned(node: LearnerNode) -> list[NextIteration]:
    outcomes = []
    while (outcome := node.learn()) is not None:
        outcomes.append(outcome)
    return outcomes


@pytest.mark.slow
def test_what_fails_in_the_middle_leaves_the_learner_as_it_was(failing: Recording, found: dict[str, Any]) -> None:
    tried, untouched = (LearnerNode(configured(**LIVE), boot="") for _ in range(2))
    pushed([tried, untouched], part(failing, 0.0, 300.0))
    assert learned(tried)[-1].served == learned(untouched)[-1].served
    with pytest.raises(BadInput, match="beyond 1e\\+30"):
        tried.relearn(effects(found), {})
    assert tried.memory(whole=True) == untouched.memory(whole=True)
    assert tried.ledger == untouched.ledger
    pushed([tried, untouched], part(failing, 300.0, 320.0))
    after, expected = learned(tried), learned(untouched)
    assert expected
    assert [each.served for each in after] == [each.served for each in expected]
    assert [each.report.batch for each in after] == [each.report.batch for each in expected]
    assert tried.batches.to_dict() == untouched.batches.to_dict()
    assert tried.batches.rejected == untouched.batches.rejected


@pytest.mark.slow
def test_where_the_recent_data_teach_nothing_the_learned_curve_stands(tmp_path: Path) -> None:
    """As while a heading is held: the effect comes into force beside the curve that was learned before."""
    write_trace(tmp_path / "trace.json")
    found = json.loads((tmp_path / "trace.json").read_text(encoding="utf-8"))
    node = LearnerNode(configured(tracing__live=True, tracing__window=240.0, tracing__proof=90.0), boot="")
    run = recording(3, 200.0)
    pushed([node], run)
    learned(node)
    held = 201.0 + 0.1 * np.arange(3190, dtype=np.float64)
    waits = np.random.default_rng(1).normal(0.0, 1e-4, held.size)
    for name, (t, value) in {"yaw_rate": (held, waits), "torque": (held, -1000.0 * waits)}.items():
        node.push(name, t, value)
    learned(node)
    before = node.latest()
    assert before is not None
    after = node.relearn(effects_from_trace(found["model"], found["effects"], leng.INERTIA, (), "a test"), {})
    assert after is not None
    assert "torque_lag" in after.report.batch.parts
    assert after.served.support == before.support
    assert after.served.revision == before.revision + 1


@pytest.mark.slow
def test_before_anything_is_learned_effects_come_into_force_and_the_first_model_holds_them(tmp_path: Path) -> None:
    write_trace(tmp_path / "trace.json")
    found = json.loads((tmp_path / "trace.json").read_text(encoding="utf-8"))
    found["effects"] = [{"effect": "torque_lag"}]
    config = configured(tracing__live=True, tracing__window=240.0, tracing__proof=90.0)
    node, effects = (
        LearnerNode(config, boot=""),
        effects_from_trace(found["model"], found["effects"], leng.INERTIA, (), "a test"),
    )
    held = 0.1 * np.arange(1500, dtype=np.float64)
    waits = np.random.default_rng(1).normal(0.0, 1e-4, held.size)
    for name, value in {"yaw_rate": waits, "torque": -1000.0 * waits}.items():
        node.push(name, held, value)
    assert not learned(node)
    assert node.relearn(effects, {}) is None
    assert node.latest() is None
    assert [each["effect"] for each in node.served.effects] == ["torque_lag"]
    restarted = LearnerNode(config, boot="", memory=node.memory(whole=True), effects=effects)
    run = recording(3, 200.0)
    pushed([node, restarted], from_table(run.name, run.time + 151.0, run.columns))
    first = learned(node)[0]
    assert first.served == learned(restarted)[0].served
    assert first.served.revision == 1
    assert [each["effect"] for each in first.served.effects] == ["torque_lag"]
    assert "torque_lag" in first.report.batch.parts


@pytest.mark.slow
def test_a_promotion_that_fails_is_in_the_ledger_and_learning_goes_on(
    failing: Recording, found: dict[str, Any], tmp_path: Path
) -> None:
    config, endpoint = configured(**LIVE, state=tmp_path), free_endpoint()
    # Without `WorkerThreads`: what comes before the proof and what after it must not depend on who is quicker.
    with open_session(listener_config_at(endpoint)) as server, closing(Host(server, config)) as host:
        assert host._live is not None
        host._live.state = TracingState(suspect=TraceContent.from_dict(found))
        with open_session(client_config_at(endpoint), PATIENCE) as client:
            ledgers: queue.Queue[wire.EffectsLedger] = queue.Queue()
            client.declare_subscriber(
                host.keys.effects,
                lambda sample: ledgers.put(wire.decode(wire.EffectsLedger, sample.payload.to_bytes())),
            )
            pushed([host.node], part(failing, 0.0, PROVEN_UNTIL))
            while not tracing():  # the proof begins with the batch that ends after enough fresh data
                assert host.learn()
            (child,) = tracing()
            child.suspend()
            pushed([host.node], part(failing, PROVEN_UNTIL, 320.0))
            while host.learn():
                pass
            child.resume()
            os.waitid(os.P_PID, child.pid, os.WEXITED | os.WNOWAIT)  # without taking its status from the learner
            assert host.tick()
            before = host.node.latest()
            host.learn()
            while not (said := ledgers.get(timeout=PATIENCE)).history:
                pass
        assert said.effects == ()
        assert {(step["effect"], step["step"]) for step in said.history} == {
            (name, "failed") for name in ("torque_lag", "bias_torque", "coupling:sway")
        }
        assert "to be promoted, but the learner could not switch to it: y holds" in said.history[0]["why"]
        assert before is not None
        assert host.node.latest() == before
        pushed([host.node], part(failing, 320.0, 360.0))
        (outcome, *_) = learned(host.node)
        assert outcome.served.revision == before.revision + 1
        assert outcome.report.batch.parts == {}
    kept = Store(tmp_path, config, changing=True)
    assert "set aside" not in " ".join(kept.notices)
    assert kept.memory is not None
    assert kept.memory["live"]["force"] is None
    kept.close()
