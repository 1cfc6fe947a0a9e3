"""The solver's figures on a few sets: what no load of the machine can spoil."""

from __future__ import annotations

from benchmarks.learner.solver import measure


def test_figures_of_the_solver() -> None:
    figures = measure(sets=10, few=1, offline=600)
    assert figures["n"] == 110
    assert figures["offline"]["n"] == 600
    assert figures["certified_error_nm"] <= 0.01
    assert figures["apart_from_clarabel_nm"] <= 1e-6
    assert figures["iterations"]["most"] <= 15
    assert figures["ratio_to_coordinate_descent"] > 20.0  # above a hundred on an idle core
    assert figures["offline"]["ratio_to_sklearn_svr_fit"] > 1.0
