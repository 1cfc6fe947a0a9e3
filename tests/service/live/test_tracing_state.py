"""What live tracing does next, and what follows from what it found: a value, without a bus and without a process."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from incsvr.compensation.promotion import Verdict
from service.live.tracing_state import STANDING_BETS, STEPS, TracingState

WINDOW, PROOF = 900.0, 300.0
LAG = {"effects": [{"effect": "torque_lag"}], "model": {}}
BIAS = {"effects": [{"effect": "bias_torque"}], "model": {}}


def due(standing: TracingState, newest: float) -> str | None:
    return standing.due(newest, WINDOW, PROOF)


def test_after_a_trace_without_a_finding_fresh_data_come_before_the_next() -> None:
    assert due(TracingState(), 900.0) == "trace"
    rests = TracingState().after_trace(900.0, None)
    assert due(rests, 1124.0) is None
    assert due(rests, 1125.0) == "trace"


def test_a_shadow_is_proven_on_what_came_after_its_trace() -> None:
    shadow = TracingState().after_trace(900.0, LAG)
    assert shadow.force is None
    assert due(shadow, 1199.0) is None
    assert due(shadow, 1200.0) == "prove"


@pytest.mark.parametrize(
    ("verdict", "force", "shadow"), [("promoted", LAG, None), ("refused", None, None), ("waits", None, LAG)]
)
def test_what_becomes_of_a_shadow(verdict: Verdict, force: object, shadow: object) -> None:
    after = TracingState().after_trace(900.0, LAG).after_proof(1200.0, verdict)
    assert (after.force, after.shadow, after.fresh) == (force, shadow, 1200.0)


def test_what_is_suspected_again_goes_on_with_what_was_bet_on_it() -> None:
    first = TracingState().after_trace(900.0, LAG)
    assert first.stake == (1, 0.0)
    refused = first.after_proof(1350.0, "refused", won=2.5)
    again = refused.after_trace(1350.0, LAG)
    assert again.stake == (1, 2.5)
    assert again.suspicions == 1
    assert TracingState.from_dict(json.loads(json.dumps(again.to_dict()))) == again
    # bets that lost more than they won begin anew, and with less chance to spend
    lost = again.after_proof(1800.0, "refused", won=-3.0).after_trace(1800.0, LAG)
    assert lost.stake == (2, 0.0)
    assert first.after_proof(1350.0, "promoted", won=5.0).bets == {}


def test_other_effects_are_another_suspicion_and_old_bets_go() -> None:
    standing = TracingState().after_trace(0.0, LAG).after_proof(1.0, "refused", won=1.0)
    other = standing.after_trace(1.0, BIAS)
    assert other.stake == (2, 0.0)
    for k in range(20):
        found = {**LAG, "effects": [{"effect": f"coupling:{k}"}]}
        other = other.after_trace(1.0, found).after_proof(2.0, "refused", won=1.0)
    assert len(other.bets) == STANDING_BETS


@pytest.mark.parametrize(("verdict", "force"), [("kept", LAG), ("doubted", LAG), ("withdrawn", None)])
def test_what_becomes_of_effects_in_force(verdict: Verdict, force: object) -> None:
    standing = TracingState(force=LAG, fresh=1200.0, traced=900.0)
    assert due(standing, 1649.0) is None
    assert due(standing, 1650.0) == "prove"
    assert standing.after_proof(1650.0, verdict).force == force


def test_more_may_be_found_beside_effects_in_force_and_takes_their_place() -> None:
    standing = TracingState(force=LAG, fresh=1700.0, traced=900.0)
    assert due(standing, 1800.0) == "trace"
    shadow = standing.after_trace(1800.0, BIAS)
    assert shadow.force == LAG
    assert shadow.tried == ("suspected", BIAS)
    assert shadow.after_proof(2100.0, "refused").force == LAG
    assert shadow.after_proof(2100.0, "promoted").force == BIAS


def test_what_waits_for_an_operator_is_proven_again_in_turn_with_what_is_in_force() -> None:
    standing = TracingState(force=LAG).after_trace(900.0, BIAS).after_proof(1200.0, "proven", {"error": {}})
    assert standing.proven == BIAS | {"proof": {"error": {}, "until": 1200.0}}
    assert standing.tried == ("force", LAG)
    again = standing.after_proof(1500.0, "kept", {"error": {}})
    assert again.tried == ("proven", standing.proven)
    assert again.after_proof(1800.0, "withdrawn").proven is None
    assert again.after_proof(1800.0, "withdrawn").force is not None


def test_what_an_operator_has_withdrawn_is_held_until_he_promotes_it() -> None:
    standing = TracingState(force=LAG).withdrawn(["torque_lag"])
    assert standing.force is None
    assert standing.held == ("torque_lag",)
    promoted = replace(standing, proven=LAG).promoted("proven")
    assert (promoted.force, promoted.proven, promoted.held) == (LAG, None, ())


def test_a_state_of_an_earlier_version_is_taken_up() -> None:
    earlier: dict[str, object] = {"force": LAG, "shadow": None, "fresh": 5.0, "traced": None}
    earlier |= {"doubted": False, "history": []}
    assert TracingState.from_dict(earlier) == TracingState(force=LAG, fresh=5.0)


def test_a_clock_that_begins_anew_makes_all_data_fresh() -> None:
    standing = TracingState(force=LAG, fresh=5000.0, traced=4000.0)
    assert standing.clock_began_anew(5000.0) == standing
    anew = standing.clock_began_anew(900.0)
    assert due(anew, 1350.0) == "prove"


def test_the_history_is_bounded_and_all_survives_a_restart_to_the_byte() -> None:
    standing = TracingState(force=LAG, fresh=0.1 + 0.2, traced=1.0, suspicions=3, held=("wave",))
    for t in range(2 * STEPS):
        standing = standing.noted({"step": "not white", "why": "p = 0", "t": float(t)})
    assert [step["t"] for step in standing.history] == [float(t) for t in range(STEPS, 2 * STEPS)]
    assert TracingState.from_dict(json.loads(json.dumps(standing.to_dict()))) == standing


def test_what_cannot_be_proven_within_half_a_window_is_overdue() -> None:
    shadow = TracingState().after_trace(900.0, {**LAG, "until": 900.0})
    assert not shadow.overdue(1349.0, WINDOW)
    assert shadow.overdue(1350.0, WINDOW)
    assert not TracingState().overdue(1350.0, WINDOW)
