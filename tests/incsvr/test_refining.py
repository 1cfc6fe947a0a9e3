"""An inner parameter found again with the weights held: it ends where the likelihood has its maximum."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from incsvr.effects import Effect, catalogue
from incsvr.tracing.run import Array
from incsvr.tracing.weak.hypothesis import Hypothesis, nothing, settle
from incsvr.tracing.weak.problem import Problem
from tests.incsvr.turning import command, instants, turning

TIME = instants(400.0)
ASKED = command(0, TIME)
CATALOGUE = catalogue()


def with_outliers(gain: Array) -> Problem:
    """A recording of which every hundredth block is an outlier."""
    problem = turning(0, ASKED, gain=gain)
    outlier = np.random.default_rng(7).random(problem.y.size) < 0.01
    return replace(problem, y=problem.y + np.where(outlier, 60.0, 0.0))


def settled(problem: Problem, effect: Effect, value: float, refine: bool) -> Hypothesis:
    terms = [(effect, (value,), ())]
    return settle(problem, terms, nothing(problem), frozenset({effect.key} if refine else ()), passes=8)


@pytest.mark.parametrize(
    ("key", "gain"),
    [
        ("torque_saturation/limit", np.minimum(50.0 / np.abs(ASKED), 1.0)),
        ("memory/linear", np.ones(TIME.size)),
    ],
)
def test_the_parameter_is_where_the_likelihood_is_largest(key: str, gain: Array) -> None:
    """Of the weights as they end, not as they were when it was sought: no value beside it explains more than chance."""
    effect, problem = CATALOGUE[key], with_outliers(gain)
    for start in effect.starts(problem.signals):
        found = settled(problem, effect, start[-1], refine=True)
        (value,) = found.terms[0].inner
        low, high = effect.bracket(problem.signals, start)
        for part in (0.02, 0.1, 0.3):
            for other in (value - part * (high - low), value + part * (high - low)):
                if low < other < high:
                    assert settled(problem, effect, other, refine=False).criterion < found.criterion + 2.0
