"""A learner on a Keelson vessel: two propellers and a yaw rate in degrees per second, in envelopes of its package."""

from __future__ import annotations

from typing import Any

import keelson
import numpy as np
from keelson.payloads.Primitives_pb2 import TimestampedBool, TimestampedFloat

from tests.service.inputs.conftest import Board
from tests.service.logs.dive import EPOCH, dive

ARM, CURVE = 0.3, 0.004
"""Moment of each propeller by its thrust [m], and thrust by its speed squared [N s²/rad²]."""
SWIM = dive(90.0, 10.0)
THRUSTERS = {
    "form": "keelson",
    "command": "rpm",
    "curve": "quadratic",
    "full": CURVE,
    "each": [
        {"topic": keelson.construct_pubsub_key("sea", "rov", "propeller_rate_rpm", "port"), "arm": ARM},
        {"topic": "sea/@v0/rov/pubsub/propeller_rate_rpm/starboard", "arm": -ARM},
    ],
}


def put(subject: str, source: str, t: float, message: Any) -> tuple[str, bytes]:
    message.timestamp.FromNanoseconds(round(1e9 * (EPOCH + t)))
    key = keelson.construct_pubsub_key("sea", "rov", subject, source)
    return key, keelson.enclose(message.SerializeToString())


def vessel_says(first: float, last: float, armed: bool = True) -> list[tuple[str, bytes]]:
    found = []
    for t, rate, torque in zip(SWIM.time, SWIM.rate, SWIM.torque, strict=True):
        if not first <= t < last:
            continue
        if t == int(t):
            found.append(put("vehicle_armed", "autopilot", t, TimestampedBool(value=armed)))
        push = torque / (2.0 * ARM)
        rpm = 30.0 / np.pi * np.sign(push) * np.sqrt(abs(push) / CURVE)
        found += [
            put("yaw_rate_degps", "imu", t, TimestampedFloat(value=np.degrees(rate))),
            put("propeller_rate_rpm", "port", t, TimestampedFloat(value=rpm)),
            put("propeller_rate_rpm", "starboard", t, TimestampedFloat(value=-rpm)),
        ]
    return found


def test_yaw_is_learned_from_propellers_and_a_gyro(board: Board) -> None:
    vessel = board({"preset": "keelson", "thrusters": THRUSTERS})
    health = vessel.send(vessel_says(0.0, 90.0), SWIM.time.size, "application/octet-stream")
    assert health.streams["torque"].received == SWIM.time.size - 1  # when a later stamp shows that both have told
    assert health.streams["torque"].value is not None
    assert abs(health.streams["torque"].value - SWIM.torque[-2]) < 1e-4
    vessel.health_when(lambda health: health.iteration >= 8)
    assert vessel.off() < 0.4


def test_without_a_torque_it_says_what_to_describe(board: Board) -> None:
    vessel = board({"preset": "keelson"})
    vessel.send(vessel_says(0.0, 5.0, armed=False), 50, "application/octet-stream")
    health = vessel.health_when(lambda health: any("Keelson sends no torque" in reason for reason in health.reasons))
    assert health.learning.why.startswith("the vehicle is not armed (by sea/@v0/rov/pubsub/vehicle_armed/autopilot)")
