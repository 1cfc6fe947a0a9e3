"""Vehicles at rest: dry friction and dead bands hold them there, and a torque that moves nothing answers nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.tracing.result import trace
from incsvr.tracing.run import Run

INERTIA, PERIOD = 350.0, 0.05
"""[kg m²], as declared; between two samples [s]."""


def instants(seconds: float) -> Array:
    return np.asarray(PERIOD * np.arange(round(seconds / PERIOD)), dtype=np.float64)


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


@pytest.mark.slow
def test_friction_that_holds_the_vehicle_is_named() -> None:
    found = trace([rubbing(0, 8.0)], inertia=INERTIA)
    assert [finding.effect for finding in found.effects] == ["coulomb"]
    assert found.effects[0].parameters["moment_nm"] == pytest.approx(8.0, rel=0.4)


def test_none_is_named_where_none_is() -> None:
    assert trace([rubbing(2, 0.0)], inertia=INERTIA).verdict == "none"


def drifting(torque: float) -> Run:
    random, time = np.random.default_rng(2), instants(600.0)
    return Run("drifting", time, random.normal(0.0, 0.002, time.size), torque + random.normal(0.0, 3.5, time.size))


@pytest.mark.parametrize("torque", [0.0, 60.0])
def test_a_torque_that_moves_nothing_answers_nothing(torque: float) -> None:
    with pytest.raises(BadInput, match=r"too little motion.*drive turns both ways"):
        trace([drifting(torque)], inertia=INERTIA)


SMALL_INERTIA_KG_M2 = 1.125
"""Moment of inertia of the small vehicle [kg m²]."""


def driven(asked: Array, half: float) -> Run:
    """A small vehicle in moving water whose thrusters lose `half` of every command [N m], told every 0.05 s."""
    random, step = np.random.default_rng(5), 0.01
    water = 0.15 * np.repeat(random.normal(size=asked.size // 5), 5)
    thrust = (np.sign(asked) * np.maximum(np.abs(asked) - half, 0.0) + water).tolist()
    rate = [0.0]
    for push in thrust[:-1]:
        rate.append(rate[-1] + step / SMALL_INERTIA_KG_M2 * (push - 0.8 * rate[-1] - 1.6 * rate[-1] * abs(rate[-1])))
    time = step * np.arange(asked.size, dtype=np.float64)[::5]
    seen = np.array(rate)[::5] + 2e-3 * random.normal(size=time.size)
    return Run("levels", time, seen, asked[::5], {})


STAIRS = np.tile(np.repeat([0.25, 0.0, -0.25, 0.5, 0.0, -0.5, 1.0, 0.0, -1.0, 0.75, 0.1, -0.75, -0.1], 300), 10)


@pytest.mark.slow
def test_a_band_is_told_under_a_few_levels() -> None:
    found = trace([driven(6.0 * STAIRS, 0.3)], inertia=SMALL_INERTIA_KG_M2, torque="commanded")
    assert [effect.effect for effect in found.effects] == ["dead_zone"]
    assert found.effects[0].parameters["half_width_nm"] == pytest.approx(0.3, abs=0.1)


@pytest.mark.slow
def test_what_silences_the_noise_of_a_measured_torque_is_no_dead_band() -> None:
    run = driven(6.0 * STAIRS, 0.0)
    noisy = replace(run, torque=run.torque + np.random.default_rng(7).normal(0.0, 0.2, run.time.size))
    found = trace([noisy], inertia=SMALL_INERTIA_KG_M2)
    assert "dead_zone" not in [effect.effect for effect in found.effects]
