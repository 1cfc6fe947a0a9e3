"""What a free run does not show is not named: a lag that only smooths the noise of a measured torque."""

from __future__ import annotations

import pytest

from incsvr.tracing import trace
from simulator.mission import Mission
from simulator.sensors import Sensor
from simulator.vehicles import TURNING
from simulator.world import play
from tests.worlds import as_run, trial


@pytest.mark.slow
def test_a_lag_that_only_smooths_a_noisy_torque_is_not_named() -> None:
    small = TURNING["small"]
    sensors = (Sensor("yaw_rate", 20.0, 0.002), Sensor("torque", 20.0, 0.06 * small.torque))
    outcome = play(Mission(small, "multisine", 3, duration=360.0, beats=25.0, sensing=lambda *_: sensors))
    found = trace([as_run(outcome.recording)], inertia=outcome.inertia)
    assert found.effects == ()
    (reason,) = (each.reason for each in found.rejected if each.effect == "torque_lag")
    assert "lowers the free run's error on held-out pieces by" in reason


@pytest.mark.slow
def test_a_lag_that_delays_the_vehicle_is_named() -> None:
    outcome = trial(3, ("torque_lag",), "small", "multisine")
    found = trace([as_run(outcome.recording)], inertia=outcome.inertia)
    assert [each.effect for each in found.effects] == ["torque_lag"]
