"""What the paper's text gives where we differ from it: each way is what it says, on one training step."""

from __future__ import annotations

from itertools import islice

import numpy as np
import pytest

from benchmarks.paper.differences import SETTINGS, Step, as_printed, figures, report, steps, stopped_by_change
from incsvr.learning.dual import coordinate_descent, solve
from incsvr.numerics import Array


@pytest.fixture(scope="module")
def three() -> list[Step]:
    return list(islice(steps(3130), 3))


def test_the_steps_are_the_learners(three: list[Step]) -> None:
    assert [one.number for one in three] == [1, 2, 3]
    assert not three[0].warm.any()
    assert three[1].warm.any()
    assert all(one.x.size == one.y.size == one.warm.size for one in three)


def test_the_signs_as_printed_leave_the_solution_and_the_right_ones_reach_it(three: list[Step]) -> None:
    one = three[1]
    exact = solve(one.x, one.y, gamma=SETTINGS.gamma, C=SETTINGS.C, epsilon=SETTINGS.epsilon)

    def dual(theta: Array) -> float:
        K = np.exp(-SETTINGS.gamma * np.subtract.outer(one.x, one.x) ** 2)
        return float(0.5 * theta @ K @ theta + SETTINGS.epsilon * np.abs(theta).sum() - one.y @ theta)

    small, passes = stopped_by_change(one)
    assert dual(as_printed(one)) > 0.0  # worse than no model at all
    assert dual(exact.weight) <= dual(small) < 0.99 * dual(exact.weight) < 0.0
    # The same passes as the learner's own, which divide the multiplier in two.
    own = coordinate_descent(
        one.x,
        one.y,
        gamma=SETTINGS.gamma,
        C=SETTINGS.C,
        epsilon=SETTINGS.epsilon,
        start=one.warm,
        passes=passes,
        gap=0.0,
    )
    assert dual(small) == pytest.approx(dual(own.weight), rel=1e-3)


def test_the_table_has_every_figure(three: list[Step]) -> None:
    found = [figures(one) for one in three]
    assert not np.isnan([each["continued"] for each in found[:2]]).any()
    assert np.isnan(found[2]["continued"])
    for each in found:
        each |= {"literal": 585.0, "trained": 3.5, "solved again": 3.6}
    text = report(found, "a command, a date")
    assert "3 training steps" in text
    assert "585" in text
    assert "nan" not in text
