"""A bus with somebody's own JSON: some keys are named, what is left out comes on the learner's own keys."""

from __future__ import annotations

import json

import numpy as np
import pytest
import zenoh

from incsvr.errors import BadInput
from service import wire
from service.config import read
from service.session import connecting, open_session
from tests.service.conftest import PATIENCE
from tests.service.inputs.conftest import Board
from tests.service.logs.dive import BOOT, dive

SWIM = dive(40.0, 20.0)
INPUTS = {
    "yaw_rate": {"topic": "sensors/gyro", "field": "gyro[2]", "unit": "deg/s", "stamp": "us", "stamp_unit": "us"},
    "channels": {"depth": {"topic": "sensors/*/depth"}},
    "armed": {"topic": "state", "field": "mode", "equals": 2},
}


def test_named_keys_beside_our_own(board: Board) -> None:
    vessel = board(INPUTS)
    messages = [("state", b'{"mode": 2}'), ("sensors/bar30/depth", b"3.25")]
    for number, (t, rate, torque) in enumerate(zip(SWIM.time, SWIM.rate, SWIM.torque, strict=True)):
        gyro = {"us": round(1e6 * (BOOT + t)), "gyro": [0.0, 0.0, float(np.degrees(rate))]}
        messages += [("sensors/gyro", json.dumps(gyro).encode())]
        messages += [(vessel.keys.torque, wire.measurement(BOOT + t, float(torque), number))]
    messages.append(("sensors/bar30/depth", b"3.5"))
    messages.append((vessel.keys.stream("voltage"), wire.measurement(BOOT + 1.0, 15.0)))
    messages.append((vessel.keys.rate, wire.measurement(BOOT, 99.0)))  # not listened to: it comes from the gyro
    vessel.send(messages, SWIM.time.size)
    health = vessel.health_when(lambda health: health.iteration >= 3 and "voltage" in health.streams)
    assert health.streams["depth"].value == 3.5
    assert (health.streams["torque"].received, health.streams["torque"].lost) == (SWIM.time.size, 0)
    assert health.streams["yaw_rate"].received == SWIM.time.size
    assert vessel.off() < 0.8  # of 13.9 N m, after half a minute
    vessel.put("state", b'{"mode": 1}')
    vessel.health_when(lambda health: health.learning.why.startswith("the vehicle is not armed (by state)"))


def test_a_flood_on_a_mapped_key_is_bounded_and_told(board: Board) -> None:
    """More than the queue holds, faster than it is emptied: the newest is kept, and every loss is counted."""
    vessel = board(INPUTS)
    large = json.dumps({"us": 1, "gyro": [0.0] * 3, "rest": "x" * 200_000}).encode()
    too_large = json.dumps({"us": 1, "gyro": [0.0] * 3, "rest": "x" * 1_100_000}).encode()
    with open_session(connecting(vessel.endpoint), PATIENCE) as flooder:
        for _ in range(100):
            flooder.put("sensors/gyro", large, congestion_control=zenoh.CongestionControl.BLOCK)
        flooder.put("sensors/gyro", too_large, congestion_control=zenoh.CongestionControl.BLOCK)
    gyro = json.dumps({"us": 5_000_000, "gyro": [0.0, 0.0, 1.0]}).encode()
    vessel.put("sensors/gyro", gyro)
    health = vessel.health_when(lambda health: health.streams["yaw_rate"].t == 5.0)
    taken, lost = health.streams["yaw_rate"].received, health.counters.get("rejected:queue_full", 0)
    assert taken + lost == 101
    assert health.counters["rejected:too_large"] == 1


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("inputs: {yaw_rate: {field: r}}", "inputs.yaw_rate.topic: Field required"),
        ("inputs: {preset: bluos}", "inputs.preset: Input should be 'blueos'"),
        ("inputs: {torque: {topic: a, unit: lb ft}}", "there is no unit 'lb ft'"),
        ("inputs: {torque: {topic: a, form: xml}}", "inputs.torque.form"),
        ("inputs: {thrusters: {command: pwm, each: [{field: a, arm: 1.0}]}}", "give the topic of the commands"),
        ("health: {diagnostics: /a/*}", "this is no key to publish on; write names with slashes between them"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(
    text: str, sentence: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.mktemp("wrong") / "config.yaml"
    path.write_text(text + "\n", encoding="utf-8")
    with pytest.raises(BadInput, match="line 1") as raised:
        read(path)
    assert sentence in str(raised.value)
    assert "pattern" not in str(raised.value)
