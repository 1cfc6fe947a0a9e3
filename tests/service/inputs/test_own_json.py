"""A bus with somebody's own JSON: some keys are named, what is left out comes on the learner's own keys."""

from __future__ import annotations

import json
from collections import Counter

import numpy as np
import pytest

from incsvr.errors import BadInput
from service import wire
from service.bus.mapped_ingest import Arrivals
from service.bus.session import free_endpoint, listener_config_at, open_session
from service.config.sources import read
from service.inputs.input_mapper import InputMapper
from service.inputs.settings import Inputs
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


def test_what_is_not_taken_in_time_is_bounded_and_told() -> None:
    """By count and by bytes: the newest is kept, in the order of arrival over all keys, and every loss is counted."""
    lost: Counter[str] = Counter()

    def tell(reason: str, count: int) -> None:
        lost[reason] += count

    hearing = InputMapper(Inputs.model_validate(INPUTS))
    with open_session(
        listener_config_at(free_endpoint())
    ) as session:  # within it a put is with its subscriber when it returns
        arrivals = Arrivals(session, hearing, tell, places=10, most_bytes=2_000_000)
        for number in range(8):
            session.put("sensors/gyro", b"x" * 400_000)
            session.put("state", b"%d" % number)
        assert lost == {"queue_full": 7}
        session.put("sensors/gyro", b"x" * 1_100_000)
        assert lost == {"queue_full": 7, "too_large": 1}
        taken = [(key, len(payload)) for key, payload, _ in arrivals.take()]
        assert taken == [("state", 1), *[("sensors/gyro", 400_000), ("state", 1)] * 4]
        for _ in range(15):
            session.put("sensors/a/depth", b"1")
        assert lost["queue_full"] == 7 + 5
        assert len(list(arrivals.take())) == 10
        arrivals.close()


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
