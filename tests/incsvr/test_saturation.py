"""Thrust that falls short at high command: the corner of its curve is as round as it is."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.effects import Effect, catalogue
from incsvr.tracing.run import Array
from incsvr.tracing.weak.hypothesis import Hypothesis, nothing, settle
from incsvr.tracing.weak.problem import Problem
from tests.incsvr.turning import command, instants, turning

TIME = instants(400.0)
LIMIT = 50.0
ROUNDED = catalogue()["torque_saturation/rounded corner"]
CUT = catalogue()["torque_saturation/limit"]
WEAKER = catalogue()["torque_asymmetry"]


def limited(asked: Array, ahead: float, astern: float, power: float) -> Problem:
    """Thrust u/(1 + |u/L|ᵖ)^(1/p) with another limit L [N m] to either side."""
    limit = np.where(asked > 0.0, ahead, astern)
    gain: Array = (1.0 + np.abs(asked / limit) ** power) ** (-1.0 / power)
    return turning(0, asked, gain=gain)


def settled(problem: Problem, effect: Effect, *others: Effect) -> Hypothesis:
    """From the start whose limit is the nearest, and of the widest corner."""
    start = min(effect.starts(problem.signals), key=lambda start: (abs(start[-1] - LIMIT), -start[0]))
    terms = [(effect, start, ()), *((other, (), ()) for other in others)]
    return settle(problem, terms, nothing(problem), frozenset({effect.key}), passes=12)


@pytest.mark.parametrize("power", [4.0, 10.0])
def test_a_corner_is_found_as_round_as_it_is(power: float) -> None:
    """And beyond it all is lost: with a corner of another width a part of it would explain more."""
    problem = limited(command(0, TIME), LIMIT, LIMIT, power)
    (term,) = settled(problem, ROUNDED).terms
    asked = np.linspace(-90.0, 90.0, 200)
    truth = asked * (1.0 + np.abs(asked / LIMIT) ** power) ** (-1.0 / power)
    assert term.coefficients[0] == pytest.approx(1.0, abs=0.03)
    np.testing.assert_allclose(ROUNDED.thrust(asked, problem.signals, term), truth, atol=0.04 * LIMIT)
