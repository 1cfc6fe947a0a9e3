"""Values put into a YAML text: in every form of a section, and nothing else changes."""

from __future__ import annotations

from typing import Any

import pytest

from incsvr.errors import BadInput
from service.config.core_yaml import Place, parse, with_values

TEXT = """\
# head
prefix: leng/yaw  # keys
vehicle: {name: rov, inertia: 0.6}   # flow
signals:
  smoothing: 0.2   # s
  channels:
    - depth

learner:
  gamma: 3

bus:"""


@pytest.mark.parametrize(
    ("place", "value", "line"),
    [
        (("prefix",), "n/yaw", 'prefix: "n/yaw"  # keys'),
        (("vehicle", "inertia"), 1.25, "vehicle: {name: rov, inertia: 1.25}   # flow"),
        (("vehicle", "rate_limit"), 2.0, "vehicle: {name: rov, inertia: 0.6, rate_limit: 2.0}   # flow"),
        (("signals", "smoothing"), 0.086, "  smoothing: 0.086   # s"),
        (("signals", "channels"), ["surge"], '    ["surge"]'),
        (("signals", "torque"), "measured", '  torque: "measured"'),
        (("learner", "C"), 60.0, "  C: 60.0"),
        (("tracing", "live"), "off", '  live: "off"'),
        (("bus", "listen"), "tcp/x:1", 'bus: {listen: "tcp/x:1"}'),
        (("state",), None, "state: null"),
    ],
)
def test_a_value_in_its_place(place: Place, value: Any, line: str) -> None:
    changed = with_values(TEXT, {place: value}, "a text")
    assert line in changed.splitlines()
    found: Any = parse(changed, "").value
    for name in place:
        found = found[int(name)] if isinstance(found, list) else found[name]
    assert found == value
    assert {each for each in TEXT.splitlines() if "#" in each and each.split(":")[0] != line.split(":")[0]} <= {
        *changed.splitlines()
    }


@pytest.mark.parametrize("text", ["", "# a comment alone\n", "{}", "learner:\n"])
def test_a_text_without_a_value(text: str) -> None:
    changed = with_values(text, {("learner", "C"): 1.0, ("learner", "gamma"): 2.0}, "a text")
    assert parse(changed, "").value == {"learner": {"C": 1.0, "gamma": 2.0}}
    assert changed.startswith(text[:1])


def test_a_section_that_others_repeat_is_refused() -> None:
    with pytest.raises(BadInput, match=r"a text: y.a cannot be written there"):
        with_values("x: &here {a: 1}\ny: *here\n", {("y", "a"): 2.0}, "a text")
