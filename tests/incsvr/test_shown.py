"""What a free run does not show is not named: a lag that only smooths the noise of a measured torque."""

from __future__ import annotations

import pytest

from incsvr.tracing import trace
from simulator.trial import Trial, play
from tests.incsvr.test_tracing import as_run


@pytest.mark.slow
@pytest.mark.parametrize("seed", [3, 6])
def test_a_lag_that_only_smooths_a_noisy_torque_is_not_named(seed: int) -> None:
    outcome = play(Trial(seed, (), 1.0, "small", "multisine", 0.0, 360.0, "measured"))
    found = trace([as_run(outcome.recording)], inertia=outcome.inertia)
    assert found.effects == ()
    (reason,) = (each.reason for each in found.rejected if each.effect == "torque_lag")
    assert "lowers the free run's error on held-out pieces by" in reason


@pytest.mark.slow
def test_a_lag_that_delays_the_vehicle_is_named() -> None:
    outcome = play(Trial(3, ("torque_lag",), 1.0, "small", "multisine", 0.0, 360.0, "measured"))
    found = trace([as_run(outcome.recording)], inertia=outcome.inertia)
    assert [each.effect for each in found.effects] == ["torque_lag"]
