"""A command of one sine, where rate, thrust and their derivatives are functions of one phase: a thruster's lag."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.numerics import Array
from incsvr.tracing.result import trace
from incsvr.tracing.run import Run
from simulator.mission import Mission
from simulator.sensors import Sensor
from simulator.vehicles import TURNING
from simulator.world import play
from tests.worlds import as_run

INERTIA = 300.0
PERIOD = 0.05
TIME = np.asarray(PERIOD * np.arange(10_000), dtype=np.float64)
COMMAND = np.asarray(100.0 * np.cos(2.0 * np.pi * TIME / 30.0), dtype=np.float64)
FINE = 10
"""Steps of the integration in a sample."""


def swung(seed: int, constant: float, sensor: float) -> Run:
    """I ṙ + 150 r + 500 r|r| = thrust, which starts from rest and follows the command in `constant` seconds [s].

    Deviations of the noise: 3.5 within each sample in the water and `sensor` of the recorded torque [N m].
    """
    random = np.random.default_rng(seed)
    rate, now, thrust = np.empty(TIME.size), 0.0, 0.0
    pushed = random.normal(0.0, 3.5, TIME.size).tolist()
    for k, asked in enumerate(COMMAND.tolist()):
        rate[k] = now
        for _ in range(FINE):
            thrust += PERIOD / FINE / constant * (asked - thrust)
            now += PERIOD / FINE / INERTIA * (thrust + pushed[k] - 150.0 * now - 500.0 * now * abs(now))
    measured: Array = rate + random.normal(0.0, 5e-4, TIME.size)
    return Run("sine", TIME, measured, COMMAND + random.normal(0.0, sensor, TIME.size), {})


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "constant", "sensor"), [(3, 0.3, 0.5), (5, 0.6, 0.9)])
def test_two_wrong_effects_do_not_stand_for_one_right(seed: int, constant: float, sensor: float) -> None:
    """A larger inertia and a saturation fit a lag's shape; a single effect does nearly as well, and the lag is it."""
    (found,) = trace([swung(seed, constant, sensor)], inertia=INERTIA).effects
    assert "torque_lag" in (found.effect, *found.cannot_tell_from)


@pytest.mark.slow
def test_a_lag_that_only_smooths_a_noisy_torque_is_not_named() -> None:
    small = TURNING["small"]
    sensors = (Sensor("yaw_rate", 20.0, 0.002), Sensor("torque", 20.0, 0.06 * small.torque))
    outcome = play(Mission(small, "multisine", 3, duration=360.0, beats=25.0, sensing=lambda *_: sensors))
    found = trace([as_run(outcome.recording)], inertia=outcome.inertia)
    assert found.effects == ()
    assert "torque_lag" in {each.effect for each in found.rejected}
