"""What live tracing does next, and what follows from what it found: a value, without a bus and without a process."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from incsvr.compensation.proof import Verdict
from incsvr.errors import BadInput
from service.live.live_tracing import LiveTracing
from service.live.tracing_state import MAX_STEPS, TraceContent, TracingState
from tests.service.conftest import configured

WINDOW, PROOF = 900.0, 300.0
LAG = TraceContent(({"effect": "torque_lag"},), {})
BIAS = TraceContent(({"effect": "bias_torque"},), {})


def due(standing: TracingState, newest: float) -> str | None:
    return standing.due(newest, WINDOW, PROOF)


def test_after_a_trace_without_a_finding_fresh_data_come_before_the_next() -> None:
    assert due(TracingState(), 900.0) == "trace"
    rests = TracingState().after_trace(900.0, None)
    assert due(rests, 1124.0) is None
    assert due(rests, 1125.0) == "trace"


def test_a_shadow_is_proven_on_what_came_after_its_trace() -> None:
    shadow = TracingState().after_trace(900.0, LAG)
    assert shadow.active is None
    assert due(shadow, 1199.0) is None
    assert due(shadow, 1200.0) == "prove"


@pytest.mark.parametrize(
    ("verdict", "active", "suspect"), [("promoted", LAG, None), ("refused", None, None), ("waits", None, LAG)]
)
def test_what_becomes_of_a_shadow(verdict: Verdict, active: object, suspect: object) -> None:
    after = TracingState().after_trace(900.0, LAG).after_proof(1200.0, verdict)
    assert (after.active, after.suspect, after.unseen_from) == (active, suspect, 1200.0)


@pytest.mark.parametrize(("verdict", "active"), [("kept", LAG), ("doubted", LAG), ("withdrawn", None)])
def test_what_becomes_of_effects_in_force(verdict: Verdict, active: object) -> None:
    standing = TracingState(active=LAG, unseen_from=1200.0, traced_until=900.0)
    assert due(standing, 1649.0) is None
    assert due(standing, 1650.0) == "prove"
    assert standing.after_proof(1650.0, verdict).active == active


def test_more_may_be_found_beside_effects_in_force_and_takes_their_place() -> None:
    standing = TracingState(active=LAG, unseen_from=1700.0, traced_until=900.0)
    assert due(standing, 1800.0) == "trace"
    shadow = standing.after_trace(1800.0, BIAS)
    assert shadow.active == LAG
    assert shadow.under_test == ("suspected", BIAS)
    assert shadow.after_proof(2100.0, "refused").active == LAG
    assert shadow.after_proof(2100.0, "promoted").active == BIAS


def test_what_waits_for_an_operator_is_proven_again_in_turn_with_what_is_in_force() -> None:
    standing = TracingState(active=LAG).after_trace(900.0, BIAS).after_proof(1200.0, "proven", {})
    assert standing.proven == replace(BIAS, proof={"error": {}, "until": 1200.0})
    assert standing.under_test == ("active", LAG)
    again = standing.after_proof(1500.0, "kept", {})
    assert again.under_test == ("proven", standing.proven)
    assert again.after_proof(1800.0, "withdrawn").proven is None
    assert again.after_proof(1800.0, "withdrawn").active is not None


def test_what_an_operator_has_withdrawn_is_held_until_he_promotes_it() -> None:
    standing = TracingState(active=LAG).withdraw(["torque_lag"])
    assert standing.active is None
    assert standing.vetoed == ("torque_lag",)
    promoted = replace(standing, proven=LAG).promote("proven")
    assert (promoted.active, promoted.proven, promoted.vetoed) == (LAG, None, ())


def test_a_state_of_an_earlier_version_is_taken_up() -> None:
    earlier: dict[str, object] = {"force": LAG.to_dict(), "shadow": None, "fresh": 5.0, "traced": None}
    earlier |= {"doubted": False, "history": []}
    assert TracingState.from_dict(earlier) == TracingState(active=LAG, unseen_from=5.0)


def test_a_clock_that_begins_anew_makes_all_data_fresh() -> None:
    standing = TracingState(active=LAG, unseen_from=5000.0, traced_until=4000.0)
    assert standing.after_clock_restart(5000.0) == standing
    anew = standing.after_clock_restart(900.0)
    assert due(anew, 1350.0) == "prove"


def test_the_history_is_bounded_and_all_survives_a_restart_to_the_byte() -> None:
    standing = TracingState(active=LAG, unseen_from=0.1 + 0.2, traced_until=1.0, vetoed=("wave",))
    for t in range(2 * MAX_STEPS):
        standing = standing.with_step({"step": "not white", "why": "p = 0", "t": float(t)})
    assert [step["t"] for step in standing.history] == [float(t) for t in range(MAX_STEPS, 2 * MAX_STEPS)]
    assert TracingState.from_dict(json.loads(json.dumps(standing.to_dict()))) == standing


def test_a_suspicion_ends_with_a_restart_or_the_clock_and_the_next_window_is_traced() -> None:
    """The data that would prove it are gone."""
    shadow = TracingState(active=BIAS).after_trace(900.0, LAG)
    restarted = TracingState.from_dict(json.loads(json.dumps(shadow.to_dict())))
    assert restarted == replace(shadow, suspect=None)
    assert shadow.after_clock_restart(10.0).suspect is None
    earlier = shadow.to_dict() | {"shadow": LAG.to_dict(), "bets": {"torque_lag": [1, 2.5]}, "suspicions": 1}
    assert TracingState.from_dict(earlier) == restarted


def test_what_cannot_be_proven_within_half_a_window_is_overdue() -> None:
    shadow = TracingState().after_trace(900.0, LAG)
    assert not shadow.overdue(1350.0, WINDOW)
    assert shadow.overdue(1351.0, WINDOW)
    assert not TracingState().overdue(1351.0, WINDOW)


def test_effects_that_an_earlier_version_wrote_are_set_aside_with_the_reason() -> None:
    before = {"inertia": 350.0, "terms": [{"effect": "torque_lag", "coefficients": [0.7]}], "origin": [0.0, 240.0]}
    content = TraceContent(({"effect": "torque_lag"},), before)
    config = configured(tracing__live="advise", vehicle__inertia=350.0)
    live = LiveTracing(
        config, TracingState(proven=content, history=({"effect": "torque_lag", "step": "proven"},)).to_dict()
    )
    assert live.state.proven is None
    assert [(each["effect"], each["step"]) for each in live.state.history] == [
        ("torque_lag", "proven"),
        ("torque_lag", "set aside"),
    ]
    assert "no trace of this version" in live.state.history[-1]["why"]
    with pytest.raises(BadInput, match=r"no trace of this version.*they are traced again"):
        LiveTracing(config, TracingState(active=content).to_dict())
