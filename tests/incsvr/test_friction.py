"""Dry friction holds the vehicle where it rests, and with it what the water would have turned."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.tracing import trace
from incsvr.tracing.run import Run
from tests.incsvr.turning import INERTIA, PERIOD, instants


def rubbing(seed: int, friction: float) -> Run:
    """I ṙ + 120 r + 700 r|r| + N_c sgn r = τ + water: levels of the command, between which it rests."""
    random = np.random.default_rng(seed)
    time = instants(480.0)
    hold = np.searchsorted(np.cumsum(random.uniform(4.0, 9.0, time.size)), time)
    torque = np.where(hold % 2 == 0, random.uniform(-80.0, 80.0, time.size)[hold], 0.0)
    kept = float(np.exp(-PERIOD / 0.3))
    water, rate, now = 0.0, np.empty(time.size), 0.0
    for k, thrust in enumerate(torque.tolist()):
        rate[k] = now
        water = kept * water + np.sqrt(1.0 - kept**2) * 3.0 * random.normal()
        moved = now + PERIOD / INERTIA * (thrust + water - 120.0 * now - 700.0 * now * abs(now))
        now = np.sign(moved) * max(abs(moved) - PERIOD / INERTIA * friction, 0.0)
    gyro = rate + random.normal(0.0, 1e-3, time.size)
    return Run("rubbing", time, gyro, torque + random.normal(0.0, 1.0, time.size), {})


def test_friction_that_holds_the_vehicle_is_named() -> None:
    found = trace([rubbing(0, 8.0)], inertia=INERTIA)
    assert [finding.effect for finding in found.effects] == ["coulomb"]
    assert found.effects[0].parameters["moment_nm"] == pytest.approx(8.0, rel=0.4)


def test_none_is_named_where_none_is() -> None:
    assert trace([rubbing(2, 0.0)], inertia=INERTIA).verdict == "none"
