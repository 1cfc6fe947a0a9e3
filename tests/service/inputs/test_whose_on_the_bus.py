"""The vehicle that a message on a bus belongs to, message by message, and what a restart keeps of it."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.writer import Writer

from incsvr.numerics import Array
from service.inputs.input_mapper import InputMapper, MappedValues
from service.inputs.settings import Inputs
from service.logs import open_any
from service.logs.reading import LogDescription, describe
from service.logs.reading import read as read_log
from tests.service import link
from tests.service.inputs.test_ros2 import IMU, STAMPED, imu, rmw, wrench_stamped
from tests.service.logs.dive import BOOT, Dive, dive

DIVE = dive(10.0)
IDLE = np.full((DIVE.time.size, 4), 1500.0)


def heard(hearing: InputMapper, messages: Iterable[tuple[str, bytes]], name: str = "torque") -> Array:
    """The values of a stream."""
    told = [each for key, payload in messages for each in hearing.hear(key, payload, 0.0)]
    return np.array([value for each in told if each.name == name for value in each.value])


def blueos(**inputs: Any) -> InputMapper:
    return InputMapper(Inputs.model_validate({"preset": "blueos", **inputs}))


def test_a_second_bank_and_a_second_battery_are_named_and_can_be_taken() -> None:
    bank = [link.outputs(t, (1100, 1900, 1500, 1500), port=1) for t in DIVE.time]
    spare = [link.battery(t + 0.001, 11.0, which=1) for t in range(10)]
    said = link.as_keys(link.in_order(link.parameters(), link.swum(DIVE), bank, spare))
    hearing = blueos()
    np.testing.assert_allclose(heard(hearing, said), DIVE.torque, atol=1e-4)
    assert {f"mavlink/1/1/{name}[1]" for name in ("SERVO_OUTPUT_RAW", "BATTERY_STATUS")} <= hearing.bindings.keys()
    assert any("SERVO_OUTPUT_RAW[1] is ignored" in note for note in hearing.notes)
    each = [{"field": "servo1_raw", "arm": -0.2}]
    thrusters = {"topic": "SERVO_OUTPUT_RAW[1]", "command": "pwm", "curve": "linear", "full": 40.0, "each": each}
    np.testing.assert_allclose(heard(blueos(thrusters=thrusters), said), 8.0)
    voltage = {"topic": "BATTERY_STATUS[1]", "field": "voltages[0]", "unit": "mV"}
    weaker = heard(blueos(channels={"voltage": voltage}), said)
    assert np.abs(weaker).max() < 0.85 * np.abs(DIVE.torque).max()


def test_outputs_that_never_come_are_named() -> None:
    functions = {f"SERVO{k}_FUNCTION": 0.0 for k in range(1, 9)} | {
        f"SERVO{k + 8}_FUNCTION": 32.0 + k for k in range(1, 9)
    }
    hearing = blueos()
    assert not heard(hearing, link.as_keys([*link.parameters(**functions), *link.swum(DIVE)])).size
    assert "outputs 9, 10, 11, 12 of SERVO_OUTPUT_RAW drive the thrusters" in hearing.missing["torque"]


def test_the_first_vehicle_that_is_armed_while_its_outputs_move_is_taken_and_stays() -> None:
    """Parameters count for the vehicle that sent them; what another process heard is kept by vehicle."""
    idle = link.of(
        1, [*link.parameters(MOT_1_DIRECTION=1.0), *link.swum(Dive(DIVE.time, -DIVE.rate, DIVE.command), IDLE)]
    )
    moves = link.of(2, [*link.parameters(), *link.swum(DIVE, armed_from=0.0)])
    hearing = blueos()
    came = [each for key, load in link.as_keys(link.in_order(idle, moves)) for each in hearing.hear(key, load, 0.0)]
    torque = [each for each in came if each.name == "torque"]
    assert hearing.system == "2"
    assert 0.8 * DIVE.time.size < len(torque) < 1.2 * DIVE.time.size
    assert torque[-1].value == pytest.approx([DIVE.torque[-1]], abs=1e-4)
    assert any("vehicle 2 is used, the first that was armed while its outputs moved" in n for n in hearing.notices())
    heard(hearing, link.as_keys(link.swum(DIVE, armed_from=0.0)))  # now the other one moves, too late
    assert hearing.system == "2"
    again = InputMapper(Inputs(preset="blueos"), hearing.parameters_by_system)
    np.testing.assert_allclose(heard(again, link.as_keys(link.of(2, link.swum(DIVE)))), DIVE.torque, atol=1e-4)
    asked = blueos(system=1)
    heard(asked, link.as_keys(link.in_order(idle, moves)))
    assert (asked.system, asked.parameters["MOT_1_DIRECTION"]) == ("1", 1.0)


def test_a_parameter_counts_from_when_it_comes() -> None:
    late = (DIVE.time >= 5.0)[:, None]
    told = np.where(late, DIVE.pulses, link.pulses(DIVE, (1, 1, 1, 1)))
    changed = [link.parameter(4.999, f"MOT_{motor}_DIRECTION", -1.0) for motor in (1, 2)]
    said = link.in_order(link.parameters(MOT_1_DIRECTION=1.0, MOT_2_DIRECTION=1.0), link.swum(DIVE, told), changed)
    hearing = blueos()
    np.testing.assert_allclose(heard(hearing, link.as_keys(said)), DIVE.torque, atol=1e-4)
    assert any("MOT_2_DIRECTION -1 (1 before) from 219.95 s on" in note for note in hearing.notes)


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
        hearing.hear(key, json.dumps(message).encode(), 0.0)
        return hearing.may_learn

    hearing.hear("r", b"0.1", 0.0)
    assert [say("u", w=1500.0), say("u", w=1506.0), say("u", w=0.0), say("u", w=1600.0)] == [False, False, False, True]
    assert any("its outputs move: it is assumed armed" in sentence for sentence in hearing.notices())
    assert [say("state", on=0.0), say("u", w=1700.0), say("state", on=1.0)] == [False, False, True]


@pytest.mark.parametrize("first", ["zed/imu", "a/imu/data"])
def test_of_several_imus_the_vehicles_is_taken(first: str) -> None:
    """Neither a camera's that comes first, nor one that has no torque in common."""
    hearing = InputMapper(Inputs(preset="ros2"))
    came: list[MappedValues] = []
    for k, (t, rate, torque) in enumerate(zip(DIVE.time, DIVE.rate, DIVE.torque, strict=True)):
        messages = [(rmw(first, IMU), imu(t, 9.0)), (rmw("rov/imu/data", IMU), imu(t, rate))]
        for key, payload in [*messages, (rmw("rov/thrust", STAMPED), wrench_stamped(t, torque))]:
            came += [each for each in hearing.hear(key, payload, 0.0) if each.name == "yaw_rate" and k > 0]
    np.testing.assert_allclose([each.value[0] for each in came], DIVE.rate[1:])
    assert any(f"{rmw(first, IMU)} is ignored" in note for note in hearing.notes)


def test_thrusters_with_topics_of_their_own_make_the_same_torque_in_a_log(tmp_path: Path) -> None:
    """Each is told at its own times, beside a rudder and a battery that are told less often."""
    rng = np.random.default_rng(780100)
    topics = {
        "r": (0.0, 0.05),
        "port": (0.0, 0.1),
        "starboard": (0.0, 0.13),
        "rudder": (0.007, 0.31),
        "volts": (0.003, 0.7),
    }
    said = sorted((float(t), name) for name, (first, step) in topics.items() for t in np.arange(first, 20.0, step))
    values = {"r": (-1.0, 1.0), "port": (1300.0, 1700.0), "starboard": (1300.0, 1700.0), "rudder": (-30.0, 30.0)}
    messages = [
        (t, name, {"t": BOOT + t, "v": float(rng.uniform(*values.get(name, (12.0, 16.0))))}) for t, name in said
    ]
    place = {"position": [-1.0, 0.4, 0.0], "pushes": [1.0, 0.0, 0.0]}
    rudder = {"topic": "rudder", "field": "v", "unit": "deg"}
    each = [
        {"topic": "port", "field": "v", **place, "turned_by": rudder},
        {"topic": "starboard", "field": "v", "arm": -0.4},
    ]
    thrusters = {"command": "pwm", "each": each, "measured_voltage": {"topic": "volts", "field": "v"}, "stamp": "t"}
    inputs = Inputs.model_validate({"yaw_rate": {"topic": "r", "field": "v", "stamp": "t"}, "thrusters": thrusters})
    hearing = InputMapper(inputs)
    live = [h for t, name, m in messages for h in hearing.hear(name, json.dumps(m).encode(), t) if h.name == "torque"]
    path = tmp_path / "ship.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        channels = {name: writer.register_channel(name, "json", 0) for name in topics}
        for t, name, message in messages:
            writer.add_message(channels[name], round(1e9 * t), json.dumps(message).encode(), 0)
        writer.finish()  # type: ignore[no-untyped-call]
    log = open_any(path)
    time, torque = read_log(path, log, describe(log, LogDescription((), inputs))).streams["torque"]
    after = time > BOOT + 0.7  # a bus does not know the first voltage before it comes
    both = [(h.t[0], h.value[0]) for h in live if h.t[0] > BOOT + 0.7]
    np.testing.assert_allclose(both, np.column_stack((time, torque))[after][: len(both)], atol=1e-9)
    assert len(both) >= after.sum() - 1
