"""The mapping message by message: clocks, units, directions, and whatever else may come."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from service.inputs.clocks import WRAP_S
from service.inputs.input_mapper import InputMapper
from service.inputs.settings import Inputs
from service.inputs.values import Values
from tests.service import link
from tests.service.logs.dive import BOOT, dive

ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)
FIELDS = ("time_boot_ms", "time_usec", "yawspeed", "base_mode", "param_id", "param_value", "servo1_raw", "voltages")


def hear(hearing: InputMapper, key: str, arrival: float, **message: Any) -> dict[str, Values]:
    return hearing.take([(key, json.dumps(message).encode(), arrival)])


def mapping(**inputs: Any) -> InputMapper:
    return InputMapper(Inputs.model_validate(inputs))


def test_stamps_of_another_clock_give_way_to_the_time_of_arrival() -> None:
    hearing = mapping(
        yaw_rate={"topic": "r", "field": "v", "stamp": "t"}, torque={"topic": "n", "field": "v", "stamp": "t"}
    )
    hear(hearing, "r", 50.0, t=10.0, v=0.1)
    assert hear(hearing, "n", 50.1, t=10.05, v=2.0)["torque"].t == 10.05
    assert not hearing.notices()
    assert hear(hearing, "n", 50.2, t=1e9, v=2.0)["torque"].t == pytest.approx(10.2)
    assert any("stamps of torque are of another clock" in sentence for sentence in hearing.notices())


def test_what_comes_again_late_does_not_move_the_clock() -> None:
    """A second link brings every yaw rate once more, five seconds late; the torque bears no stamps."""
    hearing = mapping(yaw_rate={"topic": "r", "field": "v", "stamp": "t"}, torque={"topic": "n", "field": "v"})
    for k in range(200):
        now = 0.05 * k
        hear(hearing, "r", now, t=100.0 + now, v=0.1)
        if k >= 100:
            hear(hearing, "r", now + 0.01, t=95.0 + now, v=0.1)
        assert hear(hearing, "n", now + 0.02, v=2.0)["torque"].t == pytest.approx(100.02 + now)


@pytest.mark.parametrize("unset", [range(3), range(5, 100, 10), range(100)], ids=["first", "some", "all"])
def test_a_stamp_of_zero_is_none(unset: range) -> None:
    hearing = mapping(
        yaw_rate={"topic": "r", "field": "v", "stamp": "t"}, torque={"topic": "n", "field": "v", "stamp": "t"}
    )
    begin, times = 1.7e9, []
    for k in range(100):
        stamp = 0.0 if k in unset else begin + 0.1 * k
        times += hear(hearing, "r", begin + 0.1 * k, t=stamp, v=0.1)["yaw_rate"].t.tolist()
        torque = hear(hearing, "n", begin + 0.1 * k, t=stamp, v=2.0)["torque"].t
        if k >= 3:
            assert torque == pytest.approx(times[-1], abs=1e-3)
    np.testing.assert_allclose(np.diff(times[3:]), 0.1, atol=1e-3)


def test_a_counter_of_32_bits_that_runs_over() -> None:
    hearing = InputMapper(Inputs(preset="blueos"))
    swim = dive(4.0, 10.0)
    hearing.take([(*link.as_keys(link.parameters())[0], 0.0)])
    for shift in (0.0, WRAP_S - BOOT - 2.0):
        times = []
        for key, payload in link.published(swim):
            message = json.loads(payload)["message"]
            for name, unit in (("time_boot_ms", 1e3), ("time_usec", 1e6)):
                if name in message:
                    message[name] = int((message[name] + unit * shift) % 2**32)
            heard = hear(hearing, key, 0.0, message=message)
            times += [heard["torque"].t[0]] if "torque" in heard else []
        np.testing.assert_allclose(np.diff(times), 0.1, atol=2e-3)


def test_what_the_vehicle_tells_goes_before_the_configuration_and_alone_is_kept() -> None:
    hearing = mapping(preset="blueos", parameters={"FRAME_CONFIG": 1.0, "MOT_1_DIRECTION": 1.0})
    hear(hearing, "mavlink/1/1/PARAM_VALUE", 0.0, message={"param_id": "FRAME_CONFIG", "param_value": 2.0})
    assert hearing.parameters == {"FRAME_CONFIG": 2.0, "MOT_1_DIRECTION": 1.0}
    assert hearing.parameters_by_system == {"1": {"FRAME_CONFIG": 2.0}}
    corrected = Inputs.model_validate({"preset": "blueos", "parameters": {"MOT_1_DIRECTION": -1.0}})
    assert InputMapper(corrected, hearing.parameters_by_system).parameters == {
        "FRAME_CONFIG": 2.0,
        "MOT_1_DIRECTION": -1.0,
    }


@pytest.mark.parametrize("value", [float("nan"), float("inf"), 1e300, "x", None])
def test_a_parameter_that_is_none_changes_nothing(value: Any) -> None:
    hearing = InputMapper(Inputs(preset="blueos"))
    hearing.take((*each, 0.0) for each in link.as_keys(link.parameters()) + link.published(dive(1.0, 5.0)))
    before, inputs = dict(hearing.parameters), hearing.inputs
    for name in ("SERVO1_FUNCTION", "FRAME_CONFIG", "MOT_1_DIRECTION"):
        message = {"param_id": name, "param_value": value}
        hear(hearing, "mavlink/1/1/PARAM_VALUE", 0.0, message=message)
    assert (hearing.parameters, hearing.inputs) == (before, inputs)


def test_a_rudder_turns_the_wash_of_its_propeller() -> None:
    """Rudder and propeller have a key each; before the rudder has told its angle there is no moment."""
    rudder = {"topic": "rudder", "field": "deg", "unit": "deg", "sign": -1, "scale": 0.5}
    each = {"position": [-1.0, 0.0, 0.0], "pushes": [1.0, 0.0, 0.0], "turned_by": rudder}
    hearing = mapping(
        yaw_rate={"topic": "r"},
        thrusters={"command": "N", "topic": "prop", "each": [each]},
        channels={"rudder_angle": {"topic": "rudder", "field": "deg", "unit": "deg"}},
    )
    assert list(hearing.take([("r", b"0.1", 0.0), ("prop", b"50.0", 0.0)])) == ["yaw_rate"]
    assert list(hear(hearing, "rudder", 0.1, deg=20.0)) == ["rudder_angle"]
    assert hearing.take([("prop", b"50.0", 0.2)])["torque"].value == pytest.approx([50.0 * np.sin(np.radians(10.0))])


def test_what_was_measured_before_the_vehicle_was_armed_is_not_learned_when_it_comes_late() -> None:
    hearing = mapping(yaw_rate={"topic": "r", "field": "v", "stamp": "t"}, armed={"topic": "state", "field": "on"})
    said = [("state", {"on": 0}), ("r", {"t": 1.0, "v": 0.1}), ("state", {"on": 1})]
    said += [("r", {"t": t, "v": 0.1}) for t in (0.5, 1.5)]
    came = hearing.take([(key, json.dumps(message).encode(), 5.0) for key, message in said])["yaw_rate"]
    assert (came.t.tolist(), came.learnable.tolist()) == ([1.0, 0.5, 1.5], [False, False, True])


def test_a_voltage_that_nobody_tells_is_said() -> None:
    """A monitor that is not there says 65.5 V; a voltage that is configured is no guess."""
    thrusters = {"topic": "u", "command": "pwm", "each": [{"field": "w", "arm": 0.5}]}
    for told, doubts in ((thrusters, 1), ({**thrusters, "voltage": 12.0}, 0)):
        hearing = mapping(yaw_rate={"topic": "r"}, thrusters=told, channels={"voltage": {"topic": "v", "unit": "mV"}})
        hearing.take([("r", b"0.1", 0.0), ("v", b"65535", 0.0)])
        for k in range(60):
            hear(hearing, "u", 0.1 * k, w=1900)
        assert sum("the battery's voltage is unknown" in sentence for sentence in hearing.notices()) == doubts
        hearing.take([("v", b"14000", 6.0)])
        assert hear(hearing, "u", 6.0, w=1900)["torque"].value == pytest.approx([0.5 * 4.53 * 9.80665])
        assert not hearing.notices()


@settings(max_examples=40)
@example([("HEARTBEAT", 2.0**63)])
@example([("PARAM_VALUE", 10**400)])
@given(st.lists(st.tuples(st.sampled_from(("ATTITUDE", "SERVO_OUTPUT_RAW", "HEARTBEAT", "PARAM_VALUE")), ANYTHING)))
def test_whatever_comes_nothing_is_raised(messages: list[tuple[str, Any]]) -> None:
    hearing = InputMapper(Inputs(preset="blueos"))
    hearing.take((*each, 0.0) for each in link.published(dive(1.0, 5.0)))
    for kind, anything in messages:
        for message in (anything, {"message": dict.fromkeys(FIELDS, anything)}):
            hearing.take([(f"mavlink/1/1/{kind}", json.dumps(message).encode(), 1.0)])
    hearing.notices()


@pytest.mark.parametrize(("offset", "pace", "said"), [(3.0, 1.0, 1), (-3.0, 1.0, 1), (0.3, 1.0, 0), (3.0, 50.0, 0)])
def test_a_clock_that_is_a_little_apart_is_said(offset: float, pace: float, said: int) -> None:
    """Two clocks that began seconds apart; a recording that is played shows nothing of it."""
    hearing = mapping(
        yaw_rate={"topic": "r", "field": "v", "stamp": "t"}, torque={"topic": "n", "field": "v", "stamp": "t"}
    )
    for k in range(60):
        hear(hearing, "r", 0.1 * k / pace, t=10.0 + 0.1 * k, v=0.1)
        hear(hearing, "n", 0.1 * k / pace, t=10.0 + 0.1 * k - offset, v=0.1)
    sentences = [sentence for sentence in hearing.notices() if "stamps of torque are 3 s" in sentence]
    assert len(sentences) == said
    assert all(("behind" in sentence) == (offset > 0.0) for sentence in sentences)


def test_commands_on_several_keys_make_the_same_moments_however_many_messages_come_at_once() -> None:
    """What bears one stamp is one moment, which takes the speed that was known when its last command came."""
    each = [{"topic": key, "field": "u", "arm": arm} for key, arm in (("left", 0.4), ("right", -0.4))]
    thrusters = {"command": "rad/s", "full": 0.01, "inflow": -0.02, "each": each, "stamp": "t"}
    messages = []
    for k in range(1, 60):
        t = 0.1 * k
        said = {"r": {"t": t, "v": 0.1}, "left": {"t": t, "u": 10.0 + k}, "right": {"t": t, "u": 10.0}, "dvl": {"u": t}}
        messages += [(key, json.dumps(said[key]).encode(), 5.0 + t) for key in ("r", "left", "dvl", "right")]
    wanted = [0.4 * (0.01 * ((10.0 + k) ** 2 - 100.0) - 0.02 * 0.1 * k * k) for k in range(1, 59)]
    for at_once in (1, 3, 1000):
        hearing = mapping(
            yaw_rate={"topic": "r", "field": "v", "stamp": "t"},
            thrusters=thrusters,
            channels={"surge": {"topic": "dvl", "field": "u"}},
        )
        came = [hearing.take(messages[k : k + at_once]) for k in range(0, len(messages), at_once)]
        torque = Values.joined([some["torque"] for some in came if "torque" in some])
        np.testing.assert_allclose(torque.t, 0.1 * np.arange(1, 59))
        np.testing.assert_allclose(torque.value, wanted)
