"""What a finding says to people."""

from __future__ import annotations

import re

import pytest

from incsvr.effects import catalogue
from incsvr.plant.axes import AXES
from incsvr.plant.words import words_of
from incsvr.tracing.sentences import sentence


def test_a_negative_delay_is_no_dead_time() -> None:
    delay = catalogue()["torque_delay"]
    late, ahead = (sentence(delay, {"delay_s": value}, {"delay_s": (value, value)}, 0.5) for value in (0.3, -0.3))
    assert "dead time" in late
    assert "dead time" not in ahead
    assert "stamps are late" in ahead


@pytest.mark.parametrize("name", AXES)
def test_every_effect_speaks_of_the_axis(name: str) -> None:
    words = words_of(AXES[name])
    for effect in catalogue(("depth",)).values():
        said = words.fill(effect.sentence)
        assert name == "yaw" or not re.search(r"\byaw\b", said), said
        assert words.effort == "torque" or not re.search(r"\btorque\b|(?<!Munk )\bmoment\b", said), said
