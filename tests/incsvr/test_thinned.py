"""A torque that is sampled too slowly for what moves between its samples: what follows from that is no effect."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.effects import catalogue
from incsvr.tracer.hypothesis import Hypothesis, nothing, settle
from incsvr.tracer.posing import pose
from incsvr.tracer.problem import Problem
from incsvr.tracer.run import Run
from incsvr.tracer.thinned import hangs
from simulator.trial import Trial, play
from tests.incsvr.trials import named

STEP, DECLARED = 0.02, 1.0
"""[s] of the gyro's samples, and I₀ [kg m²]."""


def fast(seed: int, every: int, inertia: float, longest: float) -> Run:
    """I ṙ + r + r|r| = τ + water, τ held for up to `longest` seconds at a time and recorded in one of `every` steps."""
    random = np.random.default_rng(seed)
    time = np.asarray(STEP * np.arange(round(200.0 / STEP)), dtype=np.float64)
    holds = np.cumsum(random.uniform(0.25 * longest, longest, time.size))
    torque = random.uniform(-5.0, 5.0, time.size)[np.searchsorted(holds, time)]
    rate, now = np.empty(time.size), 0.0
    for k, thrust in enumerate(torque.tolist()):
        rate[k] = now
        now += STEP / inertia * (thrust + random.normal(0.0, 0.5) - now - now * abs(now))
    recorded = np.full(time.size, np.nan)
    recorded[::every] = torque[::every]
    return Run("fast", time, rate + random.normal(0.0, 1e-3, time.size), recorded, {})


def with_inertia(run: Run) -> tuple[Problem, Hypothesis]:
    problem = pose([run], DECLARED, [])
    return problem, settle(problem, [(catalogue()["inertia"], (), ())], nothing(problem))


@pytest.mark.parametrize("seed", [1, 3])
def test_an_inertia_that_the_samples_feign_is_another_with_half_of_them(seed: int) -> None:
    run = fast(seed, 10, DECLARED, 0.6)
    problem, found = with_inertia(run)
    assert abs(found.terms[0].coefficients[0]) > 0.025  # though the declared one is true
    seen = hangs(problem, found, [run], [])
    assert seen is not None
    assert seen[0] == 0
    assert "how often the torque was sampled" in seen[1]


@pytest.mark.parametrize(("every", "longest"), [(1, 0.4), (5, 4.0)])
def test_a_true_one_is_the_same(every: int, longest: float) -> None:
    """Whether it is sampled in every step, or its holds are long enough for one in five."""
    for seed in range(3):
        run = fast(seed, every, 1.25, longest)
        problem, found = with_inertia(run)
        assert found.terms[0].coefficients[0] == pytest.approx(0.25, abs=0.05)
        assert hangs(problem, found, [run], []) is None


def test_a_command_of_levels_is_not_asked() -> None:
    """When it jumps, of half the samples, nobody knows: a true inertia would be another."""
    outcome = play(Trial(455_041, ("inertia",), 1.0, "small", "telegraph", 0.9, noise="torque"))
    assert named(outcome) == {"inertia"}
