"""The vehicle that a message on a bus belongs to, message by message, and what a restart keeps of it."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

import numpy as np
import pytest

from incsvr.numerics import Array
from service.inputs.input_mapper import InputMapper
from service.inputs.settings import Inputs
from tests.service import link
from tests.service.logs.dive import Dive, dive

DIVE = dive(10.0)
IDLE = np.full((DIVE.time.size, 4), 1500.0)


def heard(hearing: InputMapper, messages: Iterable[tuple[str, bytes]], name: str = "torque") -> Array:
    """The values of a stream."""
    values = hearing.take((key, payload, 0.0) for key, payload in messages).get(name)
    return np.empty(0) if values is None else values.value


def blueos(**inputs: Any) -> InputMapper:
    return InputMapper(Inputs.model_validate({"preset": "blueos", **inputs}))


def test_outputs_that_never_come_are_named() -> None:
    functions = {f"SERVO{k}_FUNCTION": 0.0 for k in range(1, 9)} | {
        f"SERVO{k + 8}_FUNCTION": 32.0 + k for k in range(1, 9)
    }
    hearing = blueos()
    assert not heard(hearing, link.as_keys([*link.parameters(**functions), *link.swum(DIVE)])).size
    assert "outputs 9, 10, 11, 12 of SERVO_OUTPUT_RAW drive the thrusters" in hearing.missing["torque"]


def test_the_first_vehicle_that_is_armed_while_its_outputs_move_is_taken_and_stays() -> None:
    """Parameters count for the vehicle that sent them; what another process heard is kept by vehicle."""
    lights = [link.outputs(t, (1100, 1900), port=1) for t in DIVE.time]  # other pulses on the same fields do not move
    swum = link.swum(Dive(DIVE.time, -DIVE.rate, DIVE.command), IDLE, armed_from=0.0)
    idle = link.of(1, link.in_order(link.parameters(MOT_1_DIRECTION=1.0), swum, lights))
    moves = link.of(2, [*link.parameters(), *link.swum(DIVE, armed_from=0.0)])
    hearing = blueos()
    torque = heard(hearing, link.as_keys(link.in_order(idle, moves)))
    assert hearing.system == "2"
    assert 0.8 * DIVE.time.size < torque.size < 1.2 * DIVE.time.size
    assert torque[-1] == pytest.approx(DIVE.torque[-1], abs=1e-4)
    assert any("vehicle 2 is used, the first that was armed while its outputs moved" in n for n in hearing.notices())
    heard(hearing, link.as_keys(link.swum(DIVE, armed_from=0.0)))  # now the other one moves, too late
    assert hearing.system == "2"
    again = InputMapper(Inputs(preset="blueos"), hearing.parameters_by_system)
    np.testing.assert_allclose(heard(again, link.as_keys(link.of(2, link.swum(DIVE)))), DIVE.torque, atol=1e-4)
    asked = blueos(system=1)
    heard(asked, link.as_keys(link.in_order(idle, moves)))
    assert (asked.system, asked.parameters["MOT_1_DIRECTION"]) == ("1", 1.0)


def test_a_boat_gets_no_bluerovs_levers() -> None:
    hearing = blueos()
    assert not heard(hearing, link.as_keys(link.swum(DIVE, kind=link.BOAT))).size
    assert "this is no BlueROV2 (its heartbeat reports type surface boat)" in hearing.missing["torque"]


def test_what_tells_changes_alone_may_have_told_the_last_one_before() -> None:
    """Outputs that move say that a vehicle is armed until something else does; outputs that tremble do not."""
    armed = {"topic": "state", "field": "on", "events": True}
    thrusters = {"topic": "u", "command": "pwm", "each": [{"field": "w", "arm": 0.5}]}
    hearing = InputMapper(Inputs.model_validate({"yaw_rate": {"topic": "r"}, "thrusters": thrusters, "armed": armed}))

    def say(key: str, **message: float) -> bool:
        hearing.take([(key, json.dumps(message).encode(), 0.0)])
        return hearing.why_not is None

    hearing.take([("r", b"0.1", 0.0)])
    assert [say("u", w=1500.0), say("u", w=1506.0), say("u", w=0.0), say("u", w=1600.0)] == [False, False, False, True]
    assert any("its outputs move: it is assumed armed" in sentence for sentence in hearing.notices())
    assert [say("state", on=0.0), say("u", w=1700.0), say("state", on=1.0)] == [False, False, True]
