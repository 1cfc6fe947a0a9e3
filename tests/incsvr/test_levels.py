"""What a thruster makes of a command that jumps within a cell."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.effects import catalogue
from incsvr.effects.effect import Term
from tests.incsvr.turning import command, instants, turning


@pytest.mark.parametrize(
    ("term", "level", "thrust"),
    [
        (Term("torque_saturation", "limit", (1.0,), (60.0,)), 90.0, 60.0),
        (Term("dead_zone", "shifted", (1.0,), (10.0,)), 90.0, 80.0),
        (Term("torque_asymmetry", "", (0.5,)), -90.0, -60.0),
    ],
)
def test_a_cell_that_holds_a_jump_gives_the_mean_of_what_either_side_does(
    term: Term, level: float, thrust: float
) -> None:
    """A quarter of it is at the new level: that is not what the thrusters make of a command between the two."""
    effect = catalogue()[f"{term.effect}/{term.variant}" if term.variant else term.effect]
    signals = turning(0, command(0, instants(200.0))).signals
    torque = np.zeros(len(signals))
    torque[599], torque[600:] = 0.25 * level, level
    after = effect.thrust(torque, signals, term)
    assert after[600] == pytest.approx(thrust)
    assert after[599] == pytest.approx(0.25 * thrust)
