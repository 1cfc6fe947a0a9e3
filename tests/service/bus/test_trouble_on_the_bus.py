"""Troubles that people had in public, as a running learner hears them: it names them within seconds, in its health."""

from __future__ import annotations

import json
import threading
import time
from itertools import count
from math import sin
from pathlib import Path

import pytest
import zenoh

from service import wire
from service.bus.session import free_endpoint
from tests.service.commands.test_processes import KEYS, client_after
from tests.service.conftest import PATIENCE

STEP_S = 0.01
"""Between two messages [s]: they come in real time, because what is told is told by when they arrive."""
CONFIG = """\
vehicle: {inertia: 0.6}
inputs:
  yaw_rate: {topic: rov/imu, field: z, stamp: t}
  torque: {topic: rov/thrust, field: z%s}
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("speed", "stamp", "second", "told"),
    [
        (0.5, "", None, "the clock of yaw_rate runs at 0.5"),
        (1.0, ", stamp: t", 0.0, "torque alternates between two series of values"),
    ],
    ids=["a simulator at half speed", "a second sender"],
)
def test_a_running_learner_names_it(tmp_path: Path, speed: float, stamp: str, second: float | None, told: str) -> None:
    path = tmp_path / "config.yaml"
    path.write_text(CONFIG % stamp, encoding="utf-8")
    said = threading.Event()

    def hear(sample: zenoh.Sample) -> None:
        if any(told in reason for reason in wire.decode(wire.Health, sample.payload.to_bytes()).reasons):
            said.set()

    with client_after(free_endpoint(), tmp_path / "state", "--config", str(path)) as (_, session, _alive):
        session.declare_subscriber(KEYS.health, hear)
        began = time.monotonic()
        for k in count():
            at = k * STEP_S * speed
            session.put("rov/imu", json.dumps({"t": at, "z": 0.5 * sin(at)}))
            session.put("rov/thrust", json.dumps({"t": at, "z": 2.0 + sin(2.0 * at)}))
            if second is not None:
                session.put("rov/thrust", json.dumps({"t": at + 0.4 * STEP_S, "z": second}))
            if said.wait(max(0.0, began + (k + 1) * STEP_S - time.monotonic())):
                return
            assert time.monotonic() < began + PATIENCE, f"nothing was said of it: {told}"
