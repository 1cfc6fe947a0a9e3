"""A declared inertia that is wrong by a factor is the headline, whichever way; one that hidden effects move is not."""

from __future__ import annotations

import pytest

from incsvr.tracing import trace
from incsvr.tracing.forward.grid import cells
from incsvr.tracing.output_error import identified
from tests.incsvr.test_coriolis import INERTIA, boat


@pytest.mark.parametrize("declared", [0.4, 5.0, INERTIA, 120.0, 2000.0])
def test_free_runs_show_the_inertia_whatever_was_declared(declared: float) -> None:
    shown = identified(cells([boat(11)], declared, []).signals)
    assert shown is not None
    assert shown.low < INERTIA < shown.high
    assert shown.inertia == pytest.approx(INERTIA, rel=0.1)
    assert shown.contradicts(declared) is (declared != INERTIA)


def test_a_munk_moment_is_no_other_inertia() -> None:
    shown = identified(cells([boat(12, munk=60.0)], INERTIA, []).signals)
    assert shown is None or not shown.contradicts(INERTIA)


def test_an_inertia_that_is_wrong_by_a_factor_is_the_headline() -> None:
    found = trace([boat(13)], inertia=5.0, validate=[boat(14)])
    first = found.effects[0]
    assert first.effect == "inertia"
    assert first.parameters["inertia_kg_m2"] == pytest.approx(INERTIA, rel=0.1)
    assert first.cannot_tell_from == ("thrust_efficiency",)
    assert "wrong by a factor of 4" in found.notes[0]
    assert found.error["after"]["free_run_rmse"] < 0.8 * found.error["before"]["free_run_rmse"]
    assert found.proven
    model = found.model
    assert model.inertia == found.inertia == 5.0
    assert model.inertia + model.terms[0].coefficients[0] == pytest.approx(first.parameters["inertia_kg_m2"])
