"""What a finding says to people."""

from __future__ import annotations

import pytest

from incsvr.effects import catalogue
from incsvr.plant.axes import AXES
from incsvr.plant.axis_words import in_words_of
from incsvr.tracing.sentences import sentence


def test_a_negative_delay_is_no_dead_time() -> None:
    delay = catalogue()["torque_delay"]
    late, ahead = (sentence(delay, {"delay_s": value}, {"delay_s": (value, value)}, 0.5) for value in (0.3, -0.3))
    assert "dead time" in late
    assert "dead time" not in ahead
    assert "stamps are late" in ahead


@pytest.mark.parametrize(("axis", "column"), [("yaw", "torque"), ("roll", "roll_torque"), ("surge", "surge_force")])
def test_a_flag_names_the_columns_of_the_axis(axis: str, column: str) -> None:
    turned = in_words_of(AXES[axis], "the torque: `--column torque=-torque`, or `--column torque=…*SCALE`")
    assert turned.endswith(f"`--column {column}=-{column}`, or `--column {column}=…*SCALE`")
    flags = "give --inertia, --torque commanded, or signals.torque and vehicle.inertia in a --config FILE"
    assert in_words_of(AXES[axis], flags) == flags
