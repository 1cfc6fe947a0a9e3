"""Rotors of which the speed lags, and thrust that lags: which of the two a recording shows, and by how much."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.model.identification import reshaped
from incsvr.model.intervals import intervals
from incsvr.numerics import Array
from incsvr.tracing.result import trace
from incsvr.tracing.run import Run
from incsvr.vehicle import identify

INERTIA_KG_M2, TOP_NM, STEP_S, SMALL = 24.0, 18.0, 0.1, 10


def driven(lag: float, of_speed: bool, seed: int, count: int = 3000) -> Run:
    """A vehicle under commands that hold for 2 s to 6 s, its rotors slow by `lag` [s] in speed or in thrust."""
    random = np.random.default_rng(seed)
    holds = random.uniform(-TOP_NM, TOP_NM, count)
    command: Array = np.repeat(holds, random.integers(20, 60, count))[:count]
    rates, rate, state, part = np.zeros(count), 0.0, 0.0, -np.expm1(-STEP_S / SMALL / lag)
    for k, asked in enumerate(command.tolist()):
        rates[k] = rate
        wanted = np.sign(asked) * np.sqrt(abs(asked)) if of_speed else asked
        for _ in range(SMALL):
            thrust = state * abs(state) if of_speed else state
            rate += STEP_S / SMALL / INERTIA_KG_M2 * (thrust - 9.0 * rate - 26.0 * rate * abs(rate))
            state += part * (wanted - state)
    time: Array = STEP_S * np.arange(count, dtype=np.float64)
    return Run("vehicle", time, rates + random.normal(0.0, 0.002, count), command, {})


@pytest.mark.slow
@pytest.mark.parametrize(("of_speed", "shape"), [(True, "rotor speed"), (False, "")])
def test_the_shape_of_a_lag_and_its_time_are_found(of_speed: bool, shape: str) -> None:
    (found,) = trace([driven(0.7, of_speed, seed=4)], inertia=INERTIA_KG_M2).effects
    assert (found.effect, found.shape) == ("torque_lag", shape)
    low, high = found.interval["time_constant_s"]
    assert 0.65 < low < 0.7 < high < 0.75


@pytest.mark.slow
def test_an_inertia_beside_a_lag_holds_for_both_shapes() -> None:
    run = driven(0.7, of_speed=True, seed=4)
    found = identify([{"yaw_rate": (run.time, run.yaw_rate), "torque": (run.time, run.torque)}])
    ((_, lag),) = found.vehicle.rotor_lags.items()
    assert (lag.low, lag.high) == pytest.approx((0.7, 0.7), abs=0.03)
    other = intervals(reshaped(found.fit))["mass:yaw_rate"]
    inertia = found.vehicle.mass["yaw", "yaw"]
    assert inertia.low <= min(other.low, INERTIA_KG_M2)
    assert inertia.high >= max(other.high, INERTIA_KG_M2)
    assert reshaped(reshaped(found.fit)).names == found.fit.names
