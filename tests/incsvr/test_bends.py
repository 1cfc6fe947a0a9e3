"""The other shapes of a larger effect: what a smaller one beside it must outdo."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.effects import Effect, Term, catalogue
from incsvr.evidence import evidence
from incsvr.tracer.alone import bends
from incsvr.tracer.asked import THRESHOLD
from incsvr.tracer.gates import objection
from incsvr.tracer.hypothesis import Hypothesis, nothing, price, views
from incsvr.tracer.posing import pose
from incsvr.tracer.problem import Problem
from incsvr.tracer.proof import Court
from incsvr.tracer.run import Array, Run
from incsvr.tracer.scan import scan, with_lead
from incsvr.tracing import trace
from simulator.trial import Trial, play
from tests.incsvr.trials import named
from tests.incsvr.turning import INERTIA, PERIOD, command, instants, turning

TIME = instants(600.0)
CATALOGUE = catalogue(["sway"])


@pytest.fixture(scope="module")
def problem() -> Problem:
    time = instants(200.0)
    return turning(0, command(0, time), channels={"sway": np.sin(0.3 * time)})


@pytest.mark.parametrize("effect", CATALOGUE.values(), ids=lambda effect: effect.key)
def test_the_other_shapes_of_every_effect_are_finite(effect: Effect, problem: Problem) -> None:
    seen = views(problem, nothing(problem)).of(effect)
    inner = (effect.starts(seen) or [(0.1,)])[0]
    term = Term(effect.name, effect.variant, tuple(np.full(effect.columns(seen, inner, ()).shape[1], 0.1)), inner)
    shapes = effect.bends(seen, term)
    assert shapes.shape[0] == len(seen)
    assert np.all(np.isfinite(shapes))


def fouled(seed: int, growth: Array) -> Problem:
    """I ṙ + (1 + growth) (120 r + 700 r|r|) = τ, with 2 N m of the water in every step."""
    random = np.random.default_rng([seed, 1])
    torque, rate, now = command(seed, TIME), np.empty(TIME.size), 0.0
    water = random.normal(0.0, 2.0, TIME.size)
    for k, factor in enumerate((1.0 + growth).tolist()):
        rate[k] = now
        now += PERIOD / INERTIA * (torque[k] + water[k] - factor * (120.0 * now + 700.0 * now * abs(now)))
    return pose([Run("fouled", TIME, rate + random.normal(0.0, 5e-4, TIME.size), torque, {})], INERTIA, [], held=True)


def drift_and_step(problem: Problem) -> Hypothesis:
    found = nothing(problem)
    for key in ("drag_drift", "drag_step"):
        found = with_lead(problem, found, scan(problem, found, [CATALOGUE[key]])[0])
    return found


@pytest.mark.parametrize("seed", [0, 1])
def test_a_drift_that_is_no_straight_line_has_no_step_beside_it(seed: int) -> None:
    problem = fouled(seed, 0.6 * (TIME / TIME[-1]) ** 0.5)
    found = drift_and_step(problem)
    asked = price(found.effects[1], 1, problem) + THRESHOLD
    assert evidence(problem, found, 1) > 2.0 * asked
    assert evidence(problem, found, 1, bends(problem, found, 1)) < asked
    reason, k = objection(problem, Court.of(problem, None, quick=True), found, 1)
    assert k == 1
    assert "another shape of a larger effect" in reason


@pytest.mark.parametrize("seed", [0, 1])
def test_a_step_beside_a_straight_drift_has(seed: int) -> None:
    """A curved drift does not take it over."""
    problem = fouled(seed, 0.4 * TIME / TIME[-1] + 0.2 * (TIME > 250.0))
    found = drift_and_step(problem)
    assert objection(problem, Court.of(problem, None, quick=True), found, 1) == ("", 0)
    assert found.terms[1].coefficients[0] == pytest.approx(0.2, abs=0.05)
    assert found.terms[1].inner[-1] == pytest.approx(250.0, abs=10.0)


def test_what_is_next_to_nothing_beside_the_others_is_the_error_of_their_shapes() -> None:
    """A limit would take less than a hundredth of what a lag and a scaled thrust explain."""
    hidden = ("modulation:temperature", "torque_lag")
    outcome = play(Trial(385_011, hidden, 1.0, "small", "closed_loop", 0.0, noise="torque"))
    columns = outcome.recording.columns
    channels = {"temperature": columns["temperature"]}
    run = Run("small", outcome.recording.time, columns["yaw_rate"], columns["torque"], channels)
    assert {found.effect for found in trace([run], inertia=outcome.inertia).effects} == set(hidden)


def test_what_makes_the_free_run_plainly_better_is_no_error_of_shapes() -> None:
    """The drift explains a hundredth of what the delay does; without it the free run is three times as far off."""
    hidden = ("torque_delay", "bias_drift")
    assert named(play(Trial(430_050, hidden, 1.0, "leng", "telegraph", 0.9))) == set(hidden)
