"""What `incsvr bench` measures, on a single repetition: its form, and what no load of the machine can spoil."""

from __future__ import annotations

from typing import Any

import pytest
from threadpoolctl import threadpool_limits

from benchmarks import learner_times
from benchmarks.bench import text
from benchmarks.bus import cost_of_many
from benchmarks.study import provenance


@pytest.fixture(scope="module")
def result() -> dict[str, Any]:
    with threadpool_limits(1):
        return learner_times.measure(seeds=1, passes=1) | {"solver": learner_times.solver(sets=3, few=1, offline=300)}


@pytest.mark.slow
def test_the_form_is_the_contracts(result: dict[str, Any]) -> None:
    assert set(result["step_ms"]) >= {"median", "p99"}
    assert set(result["ratio_to"]) == {"sklearn_svr_fit", "coordinate_descent"}
    for figures in result["policies"].values():
        assert figures["steps"] >= 20
        assert 50 <= figures["samples_trained_on"]["most"] <= 110
    shown = text(result | {"measured": provenance("incsvr bench")})
    for name in ("step_ms", "certified_error_nm", "10000_rates", "recursive_least_squares_ms", "batched_per_second"):
        assert name in shown


@pytest.mark.slow
def test_every_step_is_certified(result: dict[str, Any]) -> None:
    assert result["certified_error_nm"] <= 0.01
    assert result["solver"]["certified_error_nm"] <= 0.01
    assert result["solver"]["apart_from_clarabel_nm"] <= 1e-6


@pytest.mark.slow
def test_the_step_is_far_faster_than_the_papers_passes_and_the_signals_keep_up(result: dict[str, Any]) -> None:
    """The promise is a hundred times on an idle core; a tenth of that holds on any."""
    assert result["ratio_to"]["coordinate_descent"] > 10.0
    assert result["signals"]["batched_per_second"] > 200_000
    assert result["signals"]["single_per_second"] > 20_000


@pytest.mark.slow
def test_learners_of_one_process_are_measured() -> None:
    (few,) = cost_of_many((2,), seconds=1.0)
    assert few["learners"] == 2
    assert few["resident_mb"] > 0.0
