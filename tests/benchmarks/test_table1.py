"""Table I from the command line, and what its figures mean. (All rows, on 20 seeds, are `make table1`.)"""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from benchmarks.repetition import AT_CONVERGENCE, BEFORE_CLEANING, stopped
from benchmarks.table1 import PAPER, converged, text
from service.cli.command_line import main


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Any:
    path = tmp_path_factory.mktemp("table1") / "table1.json"
    assert main(["table1", "--seeds", "1", "--first-seed", "3110", "--quick", "--json", str(path)]) == 0
    return json.loads(path.read_text(encoding="utf-8"))


@pytest.mark.slow
def test_the_form_is_the_contracts(result: Any) -> None:
    assert result["seeds"] == 1
    rows = {(row["regressor"], row["validation"]): row for row in result["rows"]}
    assert len(rows) == len(result["rows"]) == 11
    for key, (mae, rmse, vectors) in PAPER.items():
        assert rows[key]["paper"] == {"mae": mae, "rmse": rmse, "support_vectors": vectors}
        assert 0.0 < rows[key]["mae"] < rows[key]["rmse"]
    assert [key for key in rows if key in PAPER] == list(PAPER)  # the table's own order
    assert all(row["spread"] is None for row in result["rows"])
    assert "±" not in text(result)
    for row in result["rows"]:
        trained = row["learner"] == BEFORE_CLEANING  # on the vectors kept and the new samples
        assert 0 < row["support_vectors"] <= (700 if row["regressor"] in ("B1", "B2") else 110 if trained else 60)


@pytest.mark.slow
def test_rows_are_points_of_the_curves(result: Any) -> None:
    rows = {(row["regressor"], row["validation"]): row["mae"] for row in result["rows"]}
    curves, stops = result["mae_per_iteration"], result["learners"]["paper"]["converged_by_the_papers_rule"]
    for number, validation, batches, stop in ((1, "V1", 14, stops[0]), (2, "V2", 11, stops[1])):
        assert len(curves[validation]) == batches
        assert rows[f"IncSVR{number}", validation] == curves[validation][-1]
        assert rows[f"IncSVR{number} ({AT_CONVERGENCE})", validation] == curves[validation][int(stop) - 1]
    for figures in result["learners"].values():  # the hull makes the old model wrong
        assert figures["old_model_on_V2"] > 1.3 * figures["mae_per_iteration"]["V2"][-1]


def test_the_papers_rule_takes_the_smallest_step_near_the_cross_validated_error() -> None:
    assert stopped(np.array([9.0, 5.0, 5.1, 3.2, 3.3, 4.0]), validated=3.1) == 5
    assert stopped(np.array([9.0, 5.0, 5.0, 4.0]), validated=5.0) == 3


@pytest.mark.parametrize("command", ["table1", "bench"])
def test_no_repetition_is_refused(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([command, "--seeds", "0"]) == 2
    assert "give at least one repetition" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("curve", "iterations"),
    [([5.0, 4.0, 3.0, 3.05, 3.0], 3), ([3.0, 3.0], 1), ([3.0, 4.0, 3.0], 3), ([9.0, 8.0, 7.0], 3), ([2.0], 1)],
)
def test_convergence_is_when_the_error_stays_near_its_end(curve: list[float], iterations: int) -> None:
    assert converged(np.array(curve)) == iterations
