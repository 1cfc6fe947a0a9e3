"""Water whose moment lasts for half a second: what is told in shorter blocks, and where a limit then lies."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from incsvr.effects import catalogue
from incsvr.tracing.run import Array, Run
from incsvr.tracing.weak.hypothesis import Hypothesis, nothing
from incsvr.tracing.weak.posing import pose
from incsvr.tracing.weak.problem import Problem
from incsvr.tracing.weak.scan import scan, with_lead
from tests.incsvr.turning import INERTIA, PERIOD, command, instants

TIME = instants(600.0)


def turned(seed: int, torque: Array, *, friction: float = 0.0, limit: float = np.inf) -> Run:
    """I ṙ + 120 r + 700 r|r| + friction sgn r = the torque within ±limit, plus 5 N m of the water."""
    random = np.random.default_rng([seed, 1])
    water = 5.0 * lfilter([np.sqrt(1.0 - 0.9**2)], [1.0, -0.9], random.normal(size=TIME.size))
    rate, now = np.empty(TIME.size), 0.0
    for k, moment in enumerate((np.clip(torque, -limit, limit) + water).tolist()):
        rate[k] = now
        for _ in range(4):
            drag = 120.0 * now + 700.0 * now * abs(now) + friction * np.tanh(now / 0.003)
            now += 0.25 * PERIOD / INERTIA * (moment - drag)
    measured: Array = rate + random.normal(0.0, 5e-4, TIME.size)
    return Run("turned", TIME, measured, torque, {})


def with_effect(problem: Problem, name: str) -> Hypothesis:
    """The best form of one effect."""
    base = nothing(problem)
    forms = [effect for key, effect in catalogue([]).items() if key.split("/")[0] == name]
    return max((with_lead(problem, base, lead) for lead in scan(problem, base, forms)), key=lambda h: h.criterion)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_limit_is_where_the_likelihood_has_it(seed: int) -> None:
    """Searched by least squares it gives way to a drag that the water's own turning has lowered."""
    found = with_effect(
        pose([turned(seed, command(seed, TIME), limit=60.0)], INERTIA, [], zero_order_hold=True), "torque_saturation"
    )
    assert found.terms[0].inner[-1] == pytest.approx(60.0, rel=0.03)
    assert found.terms[0].coefficients[0] == pytest.approx(1.0, abs=0.08)
