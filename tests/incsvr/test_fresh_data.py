"""Effects on trial: what free runs on fresh data say, and what follows from it."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.compensation.effects_in_force import Compensation
from incsvr.compensation.fresh_data import compare_on_fresh_data
from incsvr.compensation.promotion import FALSE_PROOF_CHANCE, Comparison, Verdict, in_force, level, on_trial
from incsvr.errors import BadInput
from incsvr.learning.learner import Settings
from incsvr.signals import SignalSettings
from incsvr.tracing.model import TracedModel
from service.recordings.recording import Streams
from simulator import leng
from tests.hidden import BIAS, LAG, TRUTH, recording, term


def effects(*terms: tuple[str, float]) -> Compensation:
    rate = np.linspace(-0.3, 0.3, 61)
    named = tuple(term(name, value) for name, value in terms)
    return Compensation.of(TracedModel(leng.INERTIA, rate, TRUTH(rate), named, 1.0, 0.3, 2.5, (0.0, 300.0)))


TRUE = effects(("torque_lag", LAG), ("bias_torque", BIAS))


@pytest.fixture(scope="module")
def streams() -> Streams:
    return recording(5, 300.0).streams()


def compared(streams: Streams, without: Compensation | None, found: Compensation) -> Comparison:
    return compare_on_fresh_data(streams, 200.0, SignalSettings(), Settings(), without, found)


def test_the_true_effects_are_promoted_and_stay(streams: Streams) -> None:
    found = compared(streams, None, TRUE)
    assert found.turned
    assert found.without + found.estimate < 0.5 * found.without
    assert found.torque_with < 0.5 * found.torque_without
    assert on_trial(found) == "promoted"
    assert in_force(found) == "kept"


def test_effects_that_the_vehicle_does_not_have_are_refused_and_withdrawn() -> None:
    straight = leng.recording("T1", seed=3).streams()
    late = effects(("torque_lag", 1.5))
    found = compare_on_fresh_data(straight, 250.0, SignalSettings(), Settings(), None, late, closed=False)
    assert on_trial(found) == "refused"
    assert in_force(found) == "withdrawn"


def test_free_runs_count_against_effects_and_never_for_them(streams: Streams) -> None:
    """Here they favour the true effects beyond doubt; in a loop that is taken for open they favour others, too."""
    in_loop, by_itself = (
        compare_on_fresh_data(streams, 200.0, SignalSettings(), Settings(), None, TRUE, closed)
        for closed in (True, False)
    )
    assert by_itself.high < 0.0
    assert (by_itself.evidence, by_itself.won) == (in_loop.evidence, in_loop.won)


@pytest.mark.slow
def test_effects_are_compared_with_those_in_force(streams: Streams) -> None:
    assert on_trial(compared(streams, TRUE, TRUE)) == "refused"
    assert on_trial(compared(streams, effects(("bias_torque", BIAS)), TRUE)) == "promoted"


def test_effects_are_proven_where_nothing_was_learned_before(streams: Streams) -> None:
    """As while a heading is held: the damping is then that of the forecasts."""
    seldom = SignalSettings(sample_period=20.0)
    found = compare_on_fresh_data(streams, 200.0, seldom, Settings(), None, TRUE)
    assert on_trial(found) == "promoted"
    assert found.without + found.estimate < 0.5 * found.without


def test_a_vehicle_that_lies_still_tells_nothing(streams: Streams) -> None:
    (t, rate), (when, torque) = streams["yaw_rate"], streams["torque"]
    still = {
        "yaw_rate": (t, np.where(t < 200.0, rate, 0.01 * rate)),
        "torque": (when, np.where(when < 200.0, torque, 0.0)),
    }
    found = compared(still, None, TRUE)
    assert not found.turned
    assert on_trial(found, last=False) == "waits"
    assert in_force(found) == "kept"


def test_too_little_before_the_fresh_data_is_said(streams: Streams) -> None:
    with pytest.raises(BadInput, match="too few to learn the damping from"):
        compare_on_fresh_data(streams, 1.0, SignalSettings(), Settings(), None, TRUE)


@pytest.mark.parametrize(
    ("evidence", "against", "trial", "force"),
    [
        (4.0, 0.0, "promoted", "kept"),
        (2.9, 0.0, "waits", "kept"),
        (0.0, 2.9, "waits", "kept"),
        (0.0, 3.1, "refused", "kept"),
        (0.0, 7.0, "refused", "withdrawn"),
    ],
)
def test_what_follows_from_the_bets(evidence: float, against: float, trial: Verdict, force: Verdict) -> None:
    found = Comparison(1.0, -0.1, -0.2, 0.1, True, 5.0, 4.0, evidence, against)
    assert (on_trial(found, last=False), in_force(found)) == (trial, force)
    assert on_trial(found) == ("promoted" if trial == "promoted" else "refused")


def test_the_chance_of_all_suspicions_together_stays_what_it_is() -> None:
    spent = sum(level(count) for count in range(1, 10_000))
    assert 0.999 * FALSE_PROOF_CHANCE < spent < FALSE_PROOF_CHANCE
