"""A torque that comes too slowly for the vehicle is said; one that is sent on change, or comes often enough, is not."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.numerics import Array
from incsvr.signals.message_rates import slow_torque
from incsvr.signals.scales import time_scale

TIME = np.arange(0.0, 200.0, 0.05, dtype=np.float64)


def held(seed: int, longest: float = 2.0) -> tuple[Array, Array]:
    """Instants and levels of a command."""
    random = np.random.default_rng(seed)
    at = np.cumsum(random.uniform(0.3, longest, 400))
    return at[at < TIME[-1]], random.uniform(-1.0, 1.0, 400)[: np.count_nonzero(at < TIME[-1])]


def turning(at: Array, levels: Array) -> Array:
    """A yaw rate that follows the levels within a quarter of a second."""
    command = levels[np.clip(np.searchsorted(at, TIME, side="right") - 1, 0, None)]
    rate = np.zeros(TIME.size)
    for k in range(1, TIME.size):
        rate[k] = rate[k - 1] + 0.2 * (command[k - 1] - rate[k - 1])
    return rate


def test_the_time_scale_of_a_cosine_is_a_sixth_of_its_period() -> None:
    assert time_scale([np.cos(2.0 * np.pi * TIME / 12.0)], 0.05) == pytest.approx(2.0, abs=0.1)


def test_commands_at_2_hz_are_said_with_the_cure() -> None:
    at, levels = held(780100)
    rate = turning(at, levels)
    found = {}
    for hz in (2.0, 20.0):
        instants = np.arange(0.1, TIME[-1], 1.0 / hz, dtype=np.float64)
        told = levels[np.clip(np.searchsorted(at, instants, side="right") - 1, 0, None)]
        found[hz] = slow_torque((TIME, rate), (instants, told))
    assert found[20.0] is None
    slow = found[2.0]
    assert slow is not None
    assert "the torque is sampled every 0.5 s" in slow.of_a_log_by("blueos")
    assert "Hz or more (on ArduPilot by the message interval of SERVO_OUTPUT_RAW" in slow.of_a_log_by("blueos")
    assert slow.on_a_bus(True).endswith(f"or more: `incsvr inspect --bus --ask {slow.hertz}` asks the vehicle for it")


def test_what_is_sent_on_change_is_known_between() -> None:
    at, levels = held(780101)
    assert slow_torque((TIME, turning(at, levels)), (at, levels)) is None


def test_noise_of_a_gyro_says_nothing_of_how_fast_a_vehicle_is() -> None:
    """It changes from sample to sample: that asked for a torque at 501 Hz."""
    noise = np.random.default_rng(780102).normal(0.0, 0.005, TIME.size)
    told = np.random.default_rng(780103).uniform(-1.0, 1.0, TIME.size)
    assert slow_torque((TIME, noise), (TIME, told)) is None
