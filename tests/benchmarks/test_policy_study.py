"""The study of the policies: its streams are what they say, and its rows are what they name."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks.learner.policy import Row, main, scenario
from benchmarks.learner.policy_baselines import NAMES
from benchmarks.learner.policy_scenarios import FIRST, RATES, SCENARIOS
from simulator import leng


@pytest.mark.parametrize("name", list(SCENARIOS))
def test_a_scenario_is_reproducible_and_true(name: str) -> None:
    case = SCENARIOS[name]
    samples, again = case.draw(3), case.draw(3)
    np.testing.assert_array_equal(samples.damping, again.damping)
    assert not np.array_equal(samples.damping, case.draw(4).damping)
    assert len(samples) == case.samples
    # The mean residual to the truth, where neither outliers nor the disturbance are, is none.
    last = samples.take(slice(case.samples - 200, None))
    residual = last.damping - np.interp(last.yaw_rate, RATES, case.truth(case.samples - 100))
    assert abs(np.median(residual)) < 3.0
    assert case.event % 50 == 0


def test_the_hull_is_in_the_truth() -> None:
    np.testing.assert_array_equal(SCENARIOS["hull on"].truth(FIRST), leng.damping(RATES))
    np.testing.assert_allclose(SCENARIOS["hull on"].truth(FIRST + 1), leng.damping(RATES, True))


def test_a_row_says_how_often_the_weighted_policy_is_better() -> None:
    row = Row("hull", "RMS", (2.0, 4.0, 6.0), (1.0, 5.0, 3.0), "seed").to_dict()
    assert row["paper"] == {"mean": 4.0, "spread": 2.0}
    assert row["ratio"] == pytest.approx(0.75)
    assert (row["weighted_better_in"], row["of"]) == (2, 3)


def test_the_weighted_policy_wins_where_it_should() -> None:
    for name in ("hull on", "low speed"):
        paper, weighted = scenario(name, 7, "paper"), scenario(name, 7, "weighted")
        for figure, value in paper.items():
            assert weighted[figure] < value


def test_the_study_writes_its_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    where = ["--measured", str(tmp_path / "none"), "--out", str(tmp_path)]
    assert main(["--seeds", "1", "--first-seed", "11", "--only", "hull on", "zigzag", *where]) == 0
    said = capsys.readouterr()
    assert "their rows are left out" in said.err
    result = json.loads((tmp_path / "policy.json").read_text(encoding="utf-8"))
    assert {row["name"] for row in result["rows"]} == {"T1 → V1", "T2 → V2", "T1, T2", "hull on", "mission: zigzag"}
    scenario, mission = result["baselines"]
    assert scenario["values"]["least squares"][0] < 3.0  # linear + quadratic is what the hull leaves of the damping
    assert set(mission["values"]) == set(NAMES)
    assert said.out == (tmp_path / "policy.md").read_text(encoding="utf-8")
    assert result["command"] in said.out
