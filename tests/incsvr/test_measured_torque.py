"""A torque that is measured with noise: what smooths the noise is no lag of the thrust."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.model.predictor import _level
from incsvr.numerics import Array, root_mean_square
from incsvr.tracing.result import trace
from incsvr.tracing.run import Run

INERTIA_KG_M2, STEP_S, SECONDS = 2.0, 0.01, 400.0


def waves(late: float, seed: int = 11) -> Run:
    """A vehicle under slow waves of torque, which act `late` [s] and are measured every 0.04 s with 3 % of noise."""
    random = np.random.default_rng(seed)
    at: Array = np.arange(0.0, SECONDS, STEP_S, dtype=np.float64)
    periods, phases = random.uniform(4.0, 20.0, 8), random.uniform(0.0, 2.0 * np.pi, 8)

    def torque(t: Array) -> Array:
        return np.asarray(np.sin(2.0 * np.pi * t[:, None] / periods + phases).sum(axis=1))

    water = 0.05 * np.repeat(random.normal(size=at.size // 20), 20)
    rate = [0.0]
    for push in (torque(at - late) + water)[:-1].tolist():
        rate.append(rate[-1] + STEP_S / INERTIA_KG_M2 * (push - 1.0 * rate[-1] - 2.0 * rate[-1] * abs(rate[-1])))
    seen = np.array(rate)[::4] + 2e-3 * random.normal(size=at.size // 4)
    return Run("waves", at[::4], seen, torque(at[::4]) + 0.15 * random.normal(size=at.size // 4), {})


@pytest.mark.slow
@pytest.mark.parametrize(("late", "named"), [(0.0, []), (0.4, ["torque_delay"])])
def test_what_smooths_the_noise_is_no_lag(late: float, named: list[str]) -> None:
    found = trace([waves(late)], inertia=INERTIA_KG_M2)
    assert [effect.effect for effect in found.effects] == named
    for effect in found.effects:
        assert effect.interval["delay_s"][0] < late < effect.interval["delay_s"][1]


def test_a_level_keeps_steps_and_a_slope_keeps_corners() -> None:
    random = np.random.default_rng(3)
    steps = np.repeat(random.normal(0.0, 5.0, 20), 25)
    ramps = np.interp(np.arange(500.0), np.arange(0.0, 525.0, 25.0), random.normal(0.0, 5.0, 21))
    noise = random.normal(size=500)
    of_steps, of_ramps = (
        [root_mean_square(_level(true + noise, 1.0, walk, order) - true) for order, walk in ((1, 0.3), (2, 0.03))]
        for true in (steps, ramps)
    )
    assert of_steps[0] < of_steps[1] < 1.0
    assert of_ramps[1] < 0.7 * of_ramps[0]
