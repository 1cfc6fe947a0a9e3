"""What a finding says to people."""

from __future__ import annotations

import ast
import re
from dataclasses import fields

import pytest

from incsvr.effects import catalogue
from incsvr.plant.axes import AXES
from incsvr.plant.words import AxisWords, words_of
from incsvr.tracing.sentences import sentence
from tests.conftest import ROOT


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


def test_a_template_names_only_words_that_there_are() -> None:
    """What a check or an effect writes is filled while a vehicle learns: a word that is not there would end that."""
    there, named = {each.name for each in fields(AxisWords)}, set[str]()
    for path in (*(ROOT / "incsvr/checks").glob("*.py"), *(ROOT / "incsvr/effects").glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                named |= set(re.findall(r"(?<!_)\{(\w+)\}", node.value))
    assert {"rate", "effort", "moment", "effort_unit"} <= named <= there
