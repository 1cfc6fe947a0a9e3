"""What is suspected stays so over a restart, and is bet on as soon as there are data to learn from and to bet on."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from benchmarks.live_watch import InPlace
from service.learner.node import LearnerNode
from service.live import worker
from service.live.live_tracing import LiveTracing
from service.live.trace_content import TraceContent
from service.live.tracing_state import TracingState
from tests.hidden import recording, write_trace
from tests.service.conftest import configured

NAMES = ("torque_lag", "bias_torque")
TRACED_UNTIL, STARTED_AGAIN = 200.0, 210.0
"""The end of the trace [s], and the first stamp after the restart [s]."""
WINDOW, PROOF = 120.0, 40.0


def suspicion(folder: Path) -> TracingState:
    """What a learner knew that had traced the vehicle."""
    write_trace(folder / "trace.json")
    model = json.loads((folder / "trace.json").read_text(encoding="utf-8"))["model"]
    effects = tuple({"effect": name} for name in NAMES)
    return TracingState().after_trace(TRACED_UNTIL, TraceContent(effects, model, "open", 80.0, TRACED_UNTIL))


def test_a_suspicion_survives_a_restart(tmp_path: Path) -> None:
    before, run = suspicion(tmp_path), recording(3, 400.0)
    config = configured(tracing__live="advise", tracing__window=WINDOW, tracing__proof=PROOF)
    node = LearnerNode(config, boot="")
    live = LiveTracing(config, json.loads(json.dumps(before.to_dict())), InPlace)
    assert live.state.suspect == before.suspect
    for start in np.arange(STARTED_AGAIN, 400.0, 3.0).tolist():
        for name, (t, value) in run.streams().items():
            part = (t >= start) & (t < start + 3.0)
            node.push(name, t[part], value[part])
        while node.learn() is not None:
            pass
        live.after(node)
        while live.waits:
            live.conclude(node)
            if live.state.proven is None:
                live.after(node)
        if live.state.proven is not None:
            break
    steps = {(step["effect"], step["step"]) for step in live.state.history}
    assert steps == {(name, "proven") for name in NAMES}
    first_look = STARTED_AGAIN + 0.5 * WINDOW + PROOF
    assert first_look <= live.state.history[-1]["t"] < first_look + PROOF


def test_the_bets_begin_with_the_first_data_after_the_trace_or_after_those_to_learn_from() -> None:
    state = TracingState().after_trace(900.0, TraceContent((), {}, until=900.0))
    assert state.trial_from == 900.0
    assert state.with_data_from(450.0, 900.0) == state
    again = state.with_data_from(1000.0, 900.0)
    assert again.trial_from == 1450.0
    assert again.with_data_from(1000.0, 900.0) == again
    assert again.due(1749.0, 900.0, 300.0) is None
    assert again.due(1750.0, 900.0, 300.0) == "prove"
    assert not again.overdue(1899.0, 900.0)
    assert again.overdue(1900.0, 900.0)
    restarted = again.after_clock_restart(10.0).with_data_from(5.0, 900.0)
    assert restarted.trial_from == 455.0


def test_a_proof_bets_on_what_came_since_its_trace_alone(tmp_path: Path) -> None:
    config = configured(tracing__live="advise", tracing__window=WINDOW, tracing__proof=PROOF)
    model = LearnerNode(config, boot="").served.model
    for state, begins in (
        (suspicion(tmp_path), TRACED_UNTIL),
        (suspicion(tmp_path).with_data_from(STARTED_AGAIN, WINDOW), STARTED_AGAIN + 0.5 * WINDOW),
    ):
        assert worker.job(config, state, "prove", 310.0, model)["fresh"] == begins
