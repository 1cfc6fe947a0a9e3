"""`incsvr inspect --bus`: what it says of a bus, and how it asks a vehicle for more."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest
import zenoh
from pymavlink.dialects.v20 import ardupilotmega as dialect

from service.bus.session import client_config_at, free_endpoint, listener_config_at, open_session
from service.cli.command_line import main
from service.inputs.input_mapper import InputMapper
from service.inputs.settings import Inputs
from service.inputs.survey import Survey
from tests.service import link
from tests.service.conftest import PATIENCE
from tests.service.logs.dive import Dive, dive

SWIM = dive(30.0, 20.0)
LIMITS = {"yaw_rate": 6.0, "torque": 40.0}


def surveyed(stream: list[tuple[str, bytes]], **inputs: Any) -> dict[str, Any]:
    """What is said of messages that arrive as fast as they were sent."""
    survey = Survey(InputMapper(Inputs.model_validate({"preset": "blueos", **inputs})), LIMITS)
    arrival = 1_000.0
    for key, payload in [*link.as_keys(link.parameters()), *stream]:
        arrival += 0.05 if key.endswith("ATTITUDE") else 0.0
        survey.take([(key, payload, arrival)])
    return survey.summary()


def with_heading(swim: Dive, sign: float = 1.0, factor: float = 1.0) -> list[tuple[str, bytes]]:
    """The same with a heading that turns as the vehicle does, and a yaw rate in another unit or direction."""
    yaw = np.cumsum(swim.rate) / 20.0
    found = link.published(Dive(swim.time, sign * factor * swim.rate, swim.command))
    turns = iter(zip(swim.time, swim.rate, (yaw + np.pi) % (2.0 * np.pi) - np.pi, strict=True))
    told = []
    for key, payload in found:
        if key.endswith("ATTITUDE"):
            t, rate, heading = next(turns)
            key, payload = link.as_key(link.attitude(t, sign * factor * rate, yaw=heading))
        told.append((key, payload))
    return told


def test_what_came_how_often_and_in_which_range() -> None:
    said = surveyed(with_heading(SWIM))
    rate, torque = said["inputs"]["yaw_rate"], said["inputs"]["torque"]
    assert (rate["count"], rate["keys"], rate["stamps"]) == (600, ["mavlink/1/1/ATTITUDE"], "own")
    assert rate["rate_hz"] == pytest.approx(20.0)
    assert (rate["low"], rate["high"]) == pytest.approx((SWIM.rate.min(), SWIM.rate.max()), abs=1e-6)
    assert torque["keys"] == ["mavlink/1/1/SERVO_OUTPUT_RAW"]
    assert said["inputs"]["voltage"]["high"] == pytest.approx(15.0)
    assert said["armed"] is True
    assert said["missing"] == {}
    assert not any(each["doubts"] for each in said["inputs"].values())


@pytest.mark.parametrize(
    ("sign", "factor", "doubt"),
    [
        (-1.0, 1.0, "one of the two has the opposite sign"),
        (1.0, 57.3, "beyond the plausible ±6 rad/s: are they in degrees per second?"),
        (1.0, 0.001, "check its unit and that of the heading"),
    ],
)
def test_a_unit_or_a_direction_that_cannot_be(sign: float, factor: float, doubt: str) -> None:
    doubts = surveyed(with_heading(SWIM, sign, factor))["inputs"]["yaw_rate"]["doubts"]
    assert any(doubt in sentence for sentence in doubts), doubts


def test_a_clock_that_is_set_under_way_is_surveyed() -> None:
    """The first message bears a stamp of zero, the next one's is since 1970: years between them are no time."""
    places = {
        name: {"topic": topic, "field": "v", "stamp": "t"} for name, topic in (("yaw_rate", "r"), ("torque", "n"))
    }
    survey = Survey(InputMapper(Inputs.model_validate(places)), LIMITS)
    for k, (t, *values) in enumerate(zip(SWIM.time, SWIM.rate, SWIM.torque, strict=True)):
        stamp, said = 0.0 if k == 0 else 1.7e9 + t, zip("rn", values, strict=True)
        survey.take((key, json.dumps({"t": stamp, "v": v}).encode(), 1_000.0 + t) for key, v in said)
    assert survey.summary()["inputs"]["yaw_rate"]["count"] == SWIM.time.size


@pytest.fixture
def bus() -> Iterator[tuple[str, zenoh.Session]]:
    endpoint = free_endpoint()
    with open_session(listener_config_at(endpoint)), open_session(client_config_at(endpoint), PATIENCE) as session:
        yield endpoint, session


@contextmanager
def repeating(session: zenoh.Session, messages: list[tuple[str, bytes]]) -> Iterator[None]:
    """Publishes these again and again."""
    stop = threading.Event()

    def work() -> None:
        while not stop.is_set():
            for key, payload in messages:
                session.put(key, payload)
            stop.wait(0.01)

    thread = threading.Thread(target=work)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()


def command(endpoint: str, *flags: str) -> list[str]:
    usual = {"--set": "inputs.preset=blueos", "--seconds": "0.6"}
    return [
        "inspect",
        "--bus",
        "--connect",
        endpoint,
        *flags,
        *(word for flag in usual if flag not in flags for word in (flag, usual[flag])),
    ]


def test_the_command_says_what_is_missing(bus: tuple[str, zenoh.Session], capsys: pytest.CaptureFixture[str]) -> None:
    endpoint, session = bus
    heard = link.as_keys([link.heartbeat(0.0, False), link.attitude(1.0, 0.1)])
    with repeating(session, heard):
        assert main(command(endpoint)) == 1
    shown = capsys.readouterr().out
    assert max(map(len, shown.splitlines())) <= 80
    for words in ("yaw_rate", "mavlink/1/1/ATTITUDE", "not armed", "missing: no SERVO_OUTPUT_RAW was found"):
        assert words in shown


def test_the_vehicle_is_asked_as_its_server_is(
    bus: tuple[str, zenoh.Session], capsys: pytest.CaptureFixture[str]
) -> None:
    """What is put on mavlink/in makes a COMMAND_LONG of MAVLink, and the autopilot's answer is told."""
    endpoint, session = bus
    asked = []

    def take(sample: zenoh.Sample) -> None:
        said = json.loads(sample.payload.to_bytes())
        fields = said["message"]
        assert fields.pop("type") == "COMMAND_LONG"
        number = getattr(dialect, fields.pop("command")["type"])
        asked.append(link.wire(dialect.MAVLink_command_long_message(command=number, **fields)))
        result = dialect.MAVLink_command_ack_message(number, len(asked) - 1)  # accepted, then refused for a while
        session.put(*link.as_key(link.Said(0.0, result), command={"type": "MAV_CMD_SET_MESSAGE_INTERVAL"}))

    session.declare_subscriber("mavlink/in", take)
    heard = link.as_keys([link.heartbeat(0.0, True), link.attitude(1.0, 0.1), link.outputs(1.0, [1500] * 4)])
    with repeating(session, heard):
        assert main(command(endpoint, "--ask", "25", "--json", "-")) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["asked"] == {"ATTITUDE": "accepted", "SERVO_OUTPUT_RAW": "refused"}
    told = [(each["command"], each["target_system"], each["param1"], each["param2"]) for each in asked]
    assert told == [(511, 1, 30.0, 40_000.0), (511, 1, 36.0, 40_000.0)]


@pytest.mark.parametrize(
    ("flags", "sentence"),
    [
        (("--ask", "0"), "--ask 0: give messages a second, above 0"),
        (("--ask", "20", "--set", "inputs.preset=ros2"), "only a vehicle with BlueOS can be asked"),
        (("--seconds", "0"), "give more than 0 s"),
    ],
)
def test_what_cannot_be_asked(flags: tuple[str, ...], sentence: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(command(free_endpoint(), *flags)) == 2
    assert sentence in capsys.readouterr().err


def test_stamps_in_another_unit() -> None:
    told = {"yaw_rate": {"topic": "ATTITUDE", "field": "yawspeed", "stamp": "time_boot_ms"}}
    assert "its stamps count milliseconds: set stamp_unit" in str(surveyed(link.published(SWIM), **told))
