"""The vehicle that a message of a log belongs to, and since when a parameter counts."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from pymavlink.dialects.v20 import ardupilotmega as dialect

from incsvr.errors import BadInput
from service.logs import open_any
from service.recordings.recording import Recording
from tests.service import link
from tests.service.logs.dive import BOOT, VOLTS, Dive, dive, read

DIVE = dive(20.0)
IDLE = np.full((DIVE.time.size, 4), 1500.0)
HALF = 10.0
"""When something changes [s]."""


def written(folder: Path, form: str, *parts: Any, **more: Any) -> Path:
    return link.WRITERS[form](folder / f"dive.{form}", link.in_order(*parts), **more)


def same(recording: Recording, wanted: np.ndarray[Any, Any], after: float = 5.0, until: float = np.inf) -> None:
    """The torque is this one while the vehicle is armed."""
    time, torque = recording.streams()["torque"]
    kept = (DIVE.time >= after) & (DIVE.time < until)
    np.testing.assert_allclose(time - BOOT, DIVE.time[kept], atol=1e-3)
    np.testing.assert_allclose(torque, wanted[kept], atol=1e-4)


def noted(recording: Recording, *words: str) -> bool:
    return any(all(word in note for word in words) for note in recording.notes)


def on_outputs(first: int) -> list[link.Said]:
    """Parameters by which motors 1 to 8 are on outputs from this one on, and the first outputs drive nothing."""
    functions = {**{f"SERVO{k}_FUNCTION": 0.0 for k in range(1, 9)}}
    return link.parameters(**functions, **{f"SERVO{first + k}_FUNCTION": 33.0 + k for k in range(8)})


@pytest.mark.parametrize("form", ["tlog", "mcap"])
def test_a_second_bank_and_a_second_battery_are_topics_of_their_own(tmp_path: Path, form: str) -> None:
    bank = [link.outputs(t, (1100, 1900, 1500, 1500), port=1) for t in DIVE.time]
    spare = [link.battery(t + 0.5, 11.0, which=1) for t in range(20)]
    path = written(tmp_path, form, link.parameters(), link.swum(DIVE), bank, spare)
    counts = {topic.name.rpartition("/")[2]: topic.count for topic in open_any(path).topics}
    assert counts["SERVO_OUTPUT_RAW"] == counts["SERVO_OUTPUT_RAW[1]"] == DIVE.time.size
    recording = read(path)
    same(recording, DIVE.torque)
    assert noted(recording, "torque is taken from SERVO_OUTPUT_RAW", "SERVO_OUTPUT_RAW[1] is ignored")
    assert noted(recording, "voltage is taken from BATTERY_STATUS (the lowest number)")
    other = read(path, "voltage=BATTERY_STATUS[1].voltages[0]:mV")
    assert np.abs(other.streams()["torque"][1]).max() < 0.85 * np.abs(recording.streams()["torque"][1]).max()
    assert not noted(other, "voltage is taken")


@pytest.mark.parametrize("form", link.WRITERS)
def test_outputs_17_to_20_are_those_of_the_second_bank(tmp_path: Path, form: str) -> None:
    bank = [link.outputs(t, [1500, 1500, *row], port=1) for t, row in zip(DIVE.time, DIVE.pulses, strict=True)]
    same(read(written(tmp_path, form, on_outputs(19), link.swum(DIVE, IDLE), bank)), DIVE.torque)


def test_the_battery_that_is_there_counts(tmp_path: Path) -> None:
    rest = [each for each in link.swum(DIVE) if each.message.get_type() != "BATTERY_STATUS"]
    batteries = [
        link.battery(t + 0.1 * which, volts, which) for t in range(20) for which, volts in ((0, 0.0), (1, VOLTS))
    ]
    same(read(written(tmp_path, "tlog", link.parameters(), rest, batteries)), DIVE.torque)


def test_outputs_that_a_link_cannot_carry_are_named(tmp_path: Path) -> None:
    """MAVLink 1 ends a message after eight outputs; with MAVLink 2 the same thrusters are learned from."""
    told = np.hstack([np.full((DIVE.time.size, 8), 1500.0), DIVE.pulses])
    parts = on_outputs(9), link.swum(DIVE, told)
    with pytest.raises(BadInput, match=r"outputs 9, 10, 11, 12 of SERVO_OUTPUT_RAW drive .* MAVLink 1 carries outputs"):
        read(written(tmp_path, "tlog", *parts, first=True))
    same(read(written(tmp_path, "tlog", *parts)), DIVE.torque)


@pytest.mark.parametrize("silence", [0, 65535])
def test_no_pulse_is_no_thrust(tmp_path: Path, silence: int) -> None:
    off = DIVE.time.astype(int) % 8 == 7
    told = np.where(off[:, None], silence, DIVE.pulses)
    same(read(written(tmp_path, "tlog", link.parameters(), link.swum(DIVE, told))), np.where(off, 0.0, DIVE.torque))


def test_named_values_are_told_apart_by_their_names(tmp_path: Path) -> None:
    told = [
        link.Said(t, dialect.MAVLink_named_value_float_message(round(1000 * (BOOT + t)), name, value))
        for t in range(20)
        for name, value in ((b"TetherTrn", 0.25 * t), (b"PilotGain", 0.5))
    ]
    path = written(tmp_path, "tlog", link.parameters(), link.swum(DIVE), told)
    turns = read(path, "tether=NAMED_VALUE_FLOAT[TetherTrn].value").streams()["tether"][1]
    np.testing.assert_allclose(turns, 0.25 * np.arange(5, 20))


@pytest.mark.parametrize("form", ["tlog", "mcap"])
@pytest.mark.parametrize("ours", [1, 2])
def test_the_vehicle_is_the_first_that_is_armed_while_its_outputs_move(tmp_path: Path, form: str, ours: int) -> None:
    """The other one sends its outputs more often, turns, and has parameters of its own."""
    mirrored = Dive(DIVE.time, -DIVE.rate, DIVE.command)
    other = link.swum(mirrored, IDLE, armed_from=1e9)
    often = [link.outputs(t + 0.02, IDLE[0]) for t in DIVE.time]
    told = link.parameters(FRAME_CONFIG=1.0, MOT_1_DIRECTION=1.0)
    ours_said = link.of(ours, link.in_order(link.parameters(), link.swum(DIVE)))
    path = written(tmp_path, form, link.of(3 - ours, link.in_order(told, other, often)), ours_said)
    recording = read(path)
    same(recording, DIVE.torque)
    assert noted(recording, f"vehicle {ours} is used", f"vehicle {3 - ours} is ignored")
    asked = read(path, learns=False, system=3 - ours)
    np.testing.assert_allclose(asked.streams()["yaw_rate"][1], mirrored.rate, atol=1e-6)
    assert not asked.columns["armed"][~np.isnan(asked.columns["armed"])].any()
    turned = read(path, "yaw_rate=-ATTITUDE.yawspeed", learns=False, system=3 - ours)
    np.testing.assert_allclose(turned.streams()["yaw_rate"][1], DIVE.rate, atol=1e-6)
    with pytest.raises(BadInput, match=r"--system 7 .* there is no such vehicle, but 1, 2"):
        read(path, system=7)


def test_parameters_of_a_vehicle_that_sends_no_yaw_rate_are_its_own(tmp_path: Path) -> None:
    told = link.of(2, [link.heartbeat(0.0, False), *link.parameters(at=1.0, FRAME_CONFIG=1.0, MOT_1_DIRECTION=1.0)])
    recording = read(written(tmp_path, "tlog", link.parameters(), link.swum(DIVE), told))
    same(recording, DIVE.torque)
    assert noted(recording, "vehicle 1 is used, the only one that sends its yaw rate")


def test_from_where_the_thrusters_are_not_known_nothing_is_learned(tmp_path: Path) -> None:
    changed = [link.parameter(HALF - 0.001, "FRAME_CONFIG", 7.0)]
    recording = read(written(tmp_path, "tlog", link.parameters(), link.swum(DIVE), changed))
    same(recording, DIVE.torque, until=HALF)
    assert noted(recording, "FRAME_CONFIG 7 (2 before) from 224.989 s on (the thrusters are not known then")


BOAT = [link.parameter(0.0, name, value) for name, value in (("SERVO1_FUNCTION", 74.0), ("SERVO3_FUNCTION", 73.0))]


@pytest.mark.parametrize(
    ("form", "parts", "because"),
    [
        ("tlog", (link.swum(DIVE, kind=link.BOAT),), "its heartbeat reports type surface boat"),
        ("mcap", (BOAT, link.swum(DIVE)), "SERVO1_FUNCTION 74 (right throttle), SERVO3_FUNCTION 73 (left throttle)"),
        ("BIN", ([link.firmware(0.0, "ArduRover V4.2.3 (9a1b2c3d)")], link.swum(DIVE)), "its firmware is ArduRover"),
        ("BIN", (BOAT, link.swum(DIVE)), "SERVO1_FUNCTION 74"),
        ("tlog", ([link.parameter(0.0, "FRAME_CLASS", 2.0)], link.swum(DIVE)), "FRAME_CLASS and no FRAME_CONFIG"),
    ],
)
def test_another_vehicle_gets_no_bluerovs_levers(tmp_path: Path, form: str, parts: Any, because: str) -> None:
    """It is asked for its thrusters, and what the sentence proposes makes the torque."""
    path = written(tmp_path, form, *parts)
    with pytest.raises(BadInput, match=re.escape(because)) as caught:
        read(path)
    proposed = re.search(r"inputs: \{.*\}", str(caught.value))
    assert proposed is not None
    inputs = yaml.safe_load(proposed[0])["inputs"]
    left, right = (2, 0) if BOAT[0] in parts[0] else (0, 2)
    wanted = 50.0 * 0.3 * (DIVE.pulses[:, left] - DIVE.pulses[:, right]) / 400.0
    same(read(path, **inputs), wanted)


def test_a_log_that_began_while_the_vehicle_was_armed(tmp_path: Path) -> None:
    said = link.parameters(), link.swum(DIVE, armed_from=0.0)
    recording = read(written(tmp_path, "BIN", *said, events=False))
    same(recording, DIVE.torque, after=float(recording.time[0]) - BOOT)
    assert recording.time[0] - BOOT <= 2.0
    assert noted(recording, "no ARM message shows whether the vehicle was armed, but its outputs move")
    silent = [each for each in link.in_order(*said) if each.message.get_type() != "HEARTBEAT"]
    assert noted(read(written(tmp_path, "tlog", silent)), "no HEARTBEAT message shows")
    for form, rest in (("BIN", {"events": False}), ("tlog", {})):
        still = [each for each in link.swum(DIVE, IDLE + 6.0) if each.message.get_type() != "HEARTBEAT"]
        with pytest.raises(BadInput, match="was never armed, so there is nothing to learn from"):
            read(written(tmp_path, form, link.parameters(), still, **rest))


@pytest.mark.parametrize(("message", "words"), [("ARM", {15.0: 0}), ("EV", {3.0: 28, 15.0: 11})])
def test_whose_first_word_is_that_it_was_disarmed(tmp_path: Path, message: str, words: dict[float, int]) -> None:
    """Events have numbers of other things, too, which say nothing of it."""
    recording = read(
        link.as_dataflash(tmp_path / "x.BIN", link.in_order(link.parameters(), link.swum(DIVE)), told=(message, words))
    )
    assert recording.time[0] - BOOT <= 2.0
    assert 14.9 < recording.time[-1] - BOOT < 15.0
    assert noted(recording, "the log began while the vehicle was armed", f"{message} reports it disarmed")


def test_events_of_other_things_do_not_disarm(tmp_path: Path) -> None:
    events = ("EV", {5.0: 10, 8.0: 28, 15.0: 15})
    recording = read(
        link.as_dataflash(tmp_path / "x.BIN", link.in_order(link.parameters(), link.swum(DIVE)), told=events)
    )
    same(recording, DIVE.torque)
