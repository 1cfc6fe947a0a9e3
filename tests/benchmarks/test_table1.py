"""Table I from the command line, and what its figures mean. (The 20 seeds are `make table1`.)"""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from benchmarks.chart import chart
from benchmarks.table1 import PAPER, converged
from service.cli import main


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Any:
    path = tmp_path_factory.mktemp("table1") / "table1.json"
    assert main(["table1", "--seeds", "1", "--json", str(path)]) == 0
    return json.loads(path.read_text(encoding="utf-8"))


def test_the_form_is_the_contracts(result: Any) -> None:
    assert result["seeds"] == 1
    rows = {(row["regressor"], row["validation"]): row for row in result["rows"]}
    assert len(rows) == len(result["rows"]) == 13
    for key, (mae, rmse, vectors) in PAPER.items():
        assert rows[key]["paper"] == {"mae": mae, "rmse": rmse, "support_vectors": vectors}
        assert 0.0 < rows[key]["mae"] < rows[key]["rmse"]
    assert [key for key in rows if key in PAPER] == list(PAPER)  # the table's own order
    assert rows["least squares", "V1"]["paper"] is None
    assert len(result["mae_per_iteration"]["V1"]) == 14
    assert len(result["mae_per_iteration"]["V2"]) == 11
    first, second = result["iterations_to_converge"]
    assert 1 <= first <= 14
    assert 1 <= second <= 11


def test_at_most_sixty_vectors_are_served(result: Any) -> None:
    learners = [row for row in result["rows"] if row["regressor"].startswith("IncSVR")]
    assert len(learners) == 4
    assert all(0 < row["support_vectors"] <= 60 for row in learners)


def test_the_last_point_of_a_curve_is_the_tables_row(result: Any) -> None:
    rows = {(row["regressor"], row["validation"]): row for row in result["rows"]}
    assert result["mae_per_iteration"]["V1"][-1] == rows["IncSVR1", "V1"]["mae"]
    assert result["mae_per_iteration"]["V2"][-1] == rows["IncSVR2", "V2"]["mae"]


def test_the_hull_makes_the_old_model_wrong(result: Any) -> None:
    for figures in result["learners"].values():
        assert figures["old_model_on_V2"] > 1.3 * figures["mae_per_iteration"]["V2"][-1]


def test_no_repetition_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["table1", "--seeds", "0"]) == 2
    assert "give at least one repetition" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("curve", "iterations"),
    [([5.0, 4.0, 3.0, 3.05, 3.0], 3), ([3.0, 3.0], 1), ([3.0, 4.0, 3.0], 3), ([9.0, 8.0, 7.0], 3), ([2.0], 1)],
)
def test_convergence_is_when_the_error_stays_near_its_end(curve: list[float], iterations: int) -> None:
    assert converged(np.array(curve)) == iterations


def test_the_chart_shows_every_point_once() -> None:
    drawn = chart({"one": [1.0, 2.0, 9.0], "two": [1.0, 3.0, 3.0]}, top=4.0, height=4)
    assert drawn.splitlines() == [
        "   4.00 |        ^",
        "   3.00 |     x  x",
        "   2.00 |     o",
        "   1.00 |  #",
        "        +---------",
        "         ",
        "         o one, x two",
    ]
