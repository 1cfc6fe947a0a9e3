"""The studies of the paper's text: each way is what it says on one training step, and a small run of each."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from benchmarks.paper import differences, tuning
from benchmarks.paper.differences import SETTINGS, Step, as_printed, figures, steps, stopped_by_change
from benchmarks.paper.repetition import LEARNERS
from incsvr.learning.dual import coordinate_descent, solve
from incsvr.learning.tuning import Grid, search
from incsvr.numerics import Array
from tests.incsvr.learning import stream


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
    gamma, C, epsilon = SETTINGS.gamma, SETTINGS.C, SETTINGS.epsilon
    exact = solve(one.x, one.y, gamma=gamma, C=C, epsilon=epsilon)

    def dual(theta: Array) -> float:
        K = np.exp(-gamma * np.subtract.outer(one.x, one.x) ** 2)
        return float(0.5 * theta @ K @ theta + epsilon * np.abs(theta).sum() - one.y @ theta)

    small, passes = stopped_by_change(one)
    assert dual(as_printed(one)) > 0.0  # worse than no model at all
    assert dual(exact.weight) <= dual(small) < 0.99 * dual(exact.weight) < 0.0
    # The same passes as the learner's own, which divide the multiplier in two.
    own = coordinate_descent(one.x, one.y, gamma=gamma, C=C, epsilon=epsilon, start=one.warm, passes=passes, gap=0.0)
    assert dual(small) == pytest.approx(dual(own.weight), rel=1e-3)


@pytest.mark.slow
def test_the_study_of_the_differences(three: list[Step], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = [figures(one) for one in three]
    assert not np.isnan([each["continued"] for each in found[:2]]).any()
    assert np.isnan(found[2]["continued"])
    for each in found:
        each |= {"literal": 585.0, "trained": 3.5, "solved again": 3.6}
    monkeypatch.setattr(differences, "examine", lambda seed: found)
    differences.main(["--seeds", "2", "--out", str(tmp_path)])
    text = (tmp_path / "differences.md").read_text(encoding="utf-8")
    assert "6 training steps" in text
    assert "585" in text
    assert "nan" not in text


def test_the_study_of_the_grid_search(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    grid = Grid(C=(0.1, 1000.0), epsilon=(0.1, 80.0), gamma=(10.0,))
    monkeypatch.setattr(tuning, "examine", lambda seed: list(search(stream(seed, 200), LEARNERS["paper"], grid)))
    tuning.main(["--seeds", "2", "--first-seed", "1", "--out", str(tmp_path)])
    lines = (tmp_path / "tuning.md").read_text(encoding="utf-8").splitlines()
    assert sum("the paper's point ranks 1 to 1, 1 in the median" in line for line in lines) == 2
    assert sum("Chosen: {1000, 0.1, 10} in 2 of 2." in line for line in lines) == 2
    rows = [line for line in lines if line.startswith("|")][2:]
    assert len(rows) == 4
    assert "← the paper's" in rows[0]
    assert rows[0].startswith("| 1000 | 0.1 | 10 |")
