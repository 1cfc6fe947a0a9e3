"""Thrust that comes to lag under way pauses learning, is traced and put in force, and learning goes on."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.live_watch import watch
from incsvr.forecasting.over_recordings import tabulated
from service.recordings.recording import Recording
from simulator import leng
from tests.service.conftest import configured

STEP, DURATION, ONSET, LAG = 0.02, 750.0, 400.0, 1.0
"""Of the simulation [s], and since when the thrust lags by how much [s]."""
WATER, WATER_MEMORY = 3.3, 0.45
"""Deviation [N m] and correlation time [s] of what the water pushes with."""


def recording(seed: int) -> Recording:
    """The Leng under a command that jumps every few seconds."""
    random, count = np.random.default_rng(seed), round(DURATION / STEP)
    command, begin = np.empty(count), 0
    while begin < count:
        end = begin + round(random.uniform(3.0, 12.0) / STEP)
        command[begin:end] = random.uniform(-90.0, 90.0)
        begin = end
    thrust, rate, water, rates = float(command[0]), 0.0, 0.0, np.empty(count)
    pushes = WATER * np.sqrt(2.0 * STEP / WATER_MEMORY) * random.standard_normal(count)
    damping = tabulated(leng.damping, 1.0)
    for k in range(count):
        rates[k] = rate
        water += pushes[k] - STEP / WATER_MEMORY * water
        rate += STEP / leng.INERTIA * (thrust + water - damping(rate, 0.0))
        thrust += (STEP / LAG if k * STEP >= ONSET else 1.0) * (command[k] - thrust)
    time = STEP * np.arange(count, dtype=np.float64)
    measured = rates + random.normal(0.0, 0.002, count)
    torque = command[::2] + random.normal(0.0, 1.0, command[::2].size)
    return Recording("lag", {"yaw_rate": (time, measured), "torque": (time[::2], torque)})


@pytest.mark.slow
def test_a_lag_that_comes_on_under_way_is_put_in_force_and_learning_goes_on() -> None:
    config = configured(tracing__live="adopt", tracing__window=240.0, tracing__proof=60.0)
    seen = watch(config, recording(5))
    steps = [(step["step"], step["effect"]) for step in seen.history]
    assert steps[:2] == [("suspected", "torque_lag"), ("promoted", "torque_lag")]
    promoted = next(step["t"] for step in seen.history if step["step"] == "promoted")
    assert promoted - ONSET <= 300.0  # three batches until it is told, half a window after them, the proof, a batch
    learned, _ = seen.residuals
    assert not np.any((learned > ONSET + 60.0) & (learned < promoted - 60.0))  # paused: no wrong curve is learned
    assert np.any(learned > promoted + 30.0)
