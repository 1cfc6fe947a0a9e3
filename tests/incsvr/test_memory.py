"""How short a memory may be before nothing tells it from the noise's colour, and what water that turns along takes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from incsvr.effects import Signals, Term, catalogue
from incsvr.effects.even_table import EvenTable

MEMORY = catalogue([])["memory/linear"]


def signals(block: float, scale: float) -> Signals:
    time = np.linspace(0.0, 10.0, 101)
    return Signals(0.1, np.array([0, 101]), time, np.sin(time), np.cos(time), block=block, scale=scale)


def test_what_is_forgotten_within_a_time_scale_is_not_tried() -> None:
    assert MEMORY.bounds(signals(0.36, 1.0))[0] == pytest.approx(1.0)


def test_a_hull_in_water_that_turns_along_drags_by_the_rate_between_the_two() -> None:
    """β of a quarter, with a drag that is steeper to one side."""
    rates = np.linspace(-2.0, 2.0, 401)
    drag = np.where(rates > 0.0, 2.0, 1.0) * (100.0 * rates + 500.0 * rates * np.abs(rates))
    s = signals(0.4, 3.0)
    table = EvenTable(-2.0, 0.01, drag)
    s = replace(s, damping=table(s.rate), drag=table)
    inner, memory = (0.7, 4.0), catalogue([])["memory/co-rotating"]
    gain = 0.25 * float(np.diff(s.drag_at(np.array([-0.7, 0.7])))[0]) / 1.4
    taken = memory.columns(s, inner, (-gain,))[:, 0] * -gain
    between = s.rate - 0.25 * s.lowpass(s.rate, 4.0)
    np.testing.assert_allclose(taken, s.drag_at(between) - s.drag_at(s.rate), atol=1e-9)
    term = Term("memory", "co-rotating", (-gain,), inner)
    assert memory.parameters(term, 350.0)["gain_nm_s"] == gain
    assert memory.implausible(term, s) == ""
    assert "against the vehicle" in memory.implausible(replace(term, coefficients=(gain,)), s)
