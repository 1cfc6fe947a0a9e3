"""The leads that a search follows: what physics forbids must not crowd out what is there."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.effects import candidates
from incsvr.tracing.weak.hypothesis import nothing, views
from incsvr.tracing.weak.problem import Problem
from incsvr.tracing.weak.scan import best_leads, scan
from tests.incsvr.turning import instants, turning

TIME = instants(400.0)
LEVEL = 60.0
"""Of the command [N m]."""


@pytest.fixture(scope="module", params=[0, 1])
def eager(request: pytest.FixtureRequest) -> Problem:
    """Two levels of the command, and 40 % more thrust than it says: every effect that takes thrust fits with its sign
    turned round."""
    seed: int = request.param
    jumps = np.cumsum(np.random.default_rng(seed).uniform(3.0, 12.0, TIME.size))
    torque = np.where(np.searchsorted(jumps, TIME) % 2 == 0, LEVEL, -LEVEL)
    return turning(seed, torque, gain=1.4)


def test_a_lead_is_doubtful_where_its_coefficient_is_against_physics(eager: Problem) -> None:
    base = nothing(eager)
    leads, seen = {lead.effect.key: lead for lead in scan(eager, base, candidates([]))}, views(eager, base)
    assert leads["torque_saturation/coefficient"].doubtful(seen)
    assert not leads["inertia"].doubtful(seen)


def test_the_doubtful_take_a_third_of_the_places(eager: Problem) -> None:
    """By their score alone they would take more, and the inertia none."""
    base = nothing(eager)
    plain, seen = scan(eager, base, candidates([]))[:6], views(eager, base)
    assert sum(lead.doubtful(seen) for lead in plain) > 2
    leads = best_leads(eager, base, candidates([]), 6)
    assert sum(lead.doubtful(seen) for lead in leads[:6]) == 2
    assert "inertia" in [lead.effect.key for lead in leads]
