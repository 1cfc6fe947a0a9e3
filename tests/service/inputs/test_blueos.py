"""A learner as one more client of a BlueOS router: `inputs: {preset: blueos}`, and the vehicle says the rest."""

from __future__ import annotations

import queue
import subprocess
from pathlib import Path

import numpy as np
import pytest
import zenoh

from service.bus.session import client_config_at, free_endpoint, listener_config_at, open_session
from service.wire import Health, Keys, ModelSnapshot, decode
from tests.service import link
from tests.service.commands.test_processes import command
from tests.service.conftest import PATIENCE
from tests.service.inputs.conftest import Board
from tests.service.logs.dive import Dive, dive


@pytest.fixture(scope="module")
def swim() -> Dive:
    """A minute and a half at 10 Hz, the usual rate of telemetry."""
    return dive(90.0, 10.0)


def test_yaw_is_learned_from_what_blueos_publishes(board: Board, swim: Dive) -> None:
    vessel = board({"preset": "blueos"})
    for key, payload in link.as_keys(link.parameters()):
        vessel.put(key, payload)
    health = vessel.send(link.published(swim), swim.time.size)
    assert health.streams["torque"].received == swim.time.size
    assert health.streams["heading"].received == swim.time.size
    vessel.health_when(lambda health: health.iteration >= 8)
    assert vessel.off() < 0.4  # of 13.9 N m; the samples scatter by 0.3
    assert not [name for name in health.counters if name.startswith("rejected:")]
    assert not [reason for reason in health.reasons if "taken for" in reason]


def test_only_while_the_autopilot_says_armed(board: Board, swim: Dive) -> None:
    """The ground station's heartbeat and the companion's have the bit as well, and the text form is read."""
    vessel = board({"preset": "blueos"})
    rest = "MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | MAV_MODE_FLAG_STABILIZE_ENABLED"

    def told(mode: str, first: float, last: float) -> list[tuple[str, bytes]]:
        own = b'"base_mode": {"bits": 209}'
        return [(key, load.replace(own, f'"base_mode": "{mode}"'.encode()) if key == "mavlink/1/1/HEARTBEAT" else load)
                for key, load in link.published(swim, first, last)]  # fmt: skip

    early, later = told(rest, 0.0, 20.0), told(f"{rest} | SAFETY_ARMED", 20.0, 40.0)
    for key, payload in link.as_keys(link.parameters()):
        vessel.put(key, payload)
    health = vessel.send(early, 200)
    health = vessel.health_when(lambda health: health.learning.state == "paused")
    assert "not armed (by mavlink/1/1/HEARTBEAT)" in health.learning.why
    assert health.counters["samples"] == 0
    assert health.streams["torque"].received == 200
    vessel.send(later, 200)
    health = vessel.health_when(lambda health: health.learning.state == "learning")
    assert 40 <= vessel.health_when(lambda health: health.counters["samples"] >= 40).counters["samples"] <= 50


def test_what_the_vehicle_has_not_told_is_said(board: Board, swim: Dive, tmp_path: Path) -> None:
    """Directions that are not told are taken for forward, aloud; told once they are kept over a restart."""

    def doubts(health: Health) -> bool:
        return any("has not sent FRAME_CONFIG and others: assumed a BlueROV2" in reason for reason in health.reasons)

    vessel = board({"preset": "blueos"}, tmp_path)
    vessel.send(link.published(swim, 0.0, 5.0), 50)
    vessel.health_when(doubts)
    for key, payload in link.as_keys(link.parameters()):
        vessel.put(key, payload)
    vessel.send(link.published(swim, 5.0, 10.0), 50)
    vessel.health_when(lambda health: not doubts(health))
    vessel.stop()
    again = board({"preset": "blueos"}, tmp_path)
    again.send(link.published(swim, 10.0, 15.0), 50)
    assert not doubts(again.health_when(lambda health: health.streams["torque"].received >= 49))
    said = board({"preset": "blueos", "parameters": {"FRAME_CONFIG": 7.0}})
    said.send(link.published(swim, 0.0, 2.0), 20)
    health = said.health_when(lambda health: any("levers of frame 7" in reason for reason in health.reasons))
    assert "torque" not in {name for name, stream in health.streams.items() if stream.received}


def test_outputs_that_do_not_come_are_missed_with_the_cure(board: Board, swim: Dive) -> None:
    vessel = board({"preset": "blueos"})
    silent = [each for each in link.published(swim, 0.0, 5.0) if not each[0].endswith("SERVO_OUTPUT_RAW")]
    vessel.send(silent, 50)
    vessel.health_when(
        lambda health: health.level == "STALE" and any("no SERVO_OUTPUT_RAW" in reason for reason in health.reasons)
    )


def test_outputs_at_2_hz_are_too_slow_for_the_vehicle_and_the_cure_is_a_command(board: Board, swim: Dive) -> None:
    vessel = board({"preset": "blueos"})
    messages, told = link.as_keys(link.parameters()), 0
    for key, payload in link.published(swim, 0.0, 40.0):
        told += key.endswith("SERVO_OUTPUT_RAW")
        if not key.endswith("SERVO_OUTPUT_RAW") or told % 5 == 0:
            messages.append((key, payload))
    vessel.send(messages, 400)
    health = vessel.health_when(
        lambda health: any("`incsvr inspect --bus --ask" in reason for reason in health.reasons)
    )
    (slow,) = (reason for reason in health.reasons if "--ask" in reason)
    assert slow.startswith("the torque is sampled every 0.5 s, too seldom for a vehicle whose yaw rate changes within")


@pytest.mark.slow
def test_the_process_learns_from_two_lines_behind_a_router(swim: Dive, tmp_path: Path) -> None:
    config, endpoint, keys = tmp_path / "config.yaml", free_endpoint(), Keys("leng/yaw")
    config.write_text("inputs: {preset: blueos}\nvehicle: {inertia: 0.6, rate_range: [-2.8, 2.8]}\n", encoding="utf-8")
    serve = command("serve", "--config", str(config), "--connect", endpoint, "--set", "state=null")
    models: queue.Queue[ModelSnapshot] = queue.Queue()
    alive: queue.Queue[str] = queue.Queue()
    with open_session(listener_config_at(endpoint)), open_session(client_config_at(endpoint), PATIENCE) as session:
        session.declare_subscriber(keys.model, lambda sample: models.put(read_model(sample)))
        session.liveliness().declare_subscriber(keys.alive, lambda sample: alive.put(str(sample.kind)), history=True)
        process = subprocess.Popen(serve, stderr=subprocess.DEVNULL)
        try:
            alive.get(timeout=3.0 * PATIENCE)  # a process starts slowly on a busy machine
            for number, (key, payload) in enumerate(link.as_keys(link.parameters()) + link.published(swim, 0.0, 65.0)):
                session.put(key, payload, congestion_control=zenoh.CongestionControl.BLOCK)
                if number % 100 == 0:  # no faster than it is read
                    assert [reply.ok for reply in session.get(keys.health, timeout=PATIENCE)]
            model = [models.get(timeout=PATIENCE) for _ in range(2)][-1]
        finally:
            process.kill()
            process.wait()
    rate = np.linspace(-2.0, 2.0, 21)
    off = np.abs(model.model.predict(rate).damping - 0.6 * rate - 1.6 * rate * np.abs(rate))
    assert off.mean() < 0.8  # of 7.6 N m at 2 rad/s; the preset's filter is wide for a vehicle as quick as this one


def read_model(sample: zenoh.Sample) -> ModelSnapshot:
    return decode(ModelSnapshot, sample.payload.to_bytes())
