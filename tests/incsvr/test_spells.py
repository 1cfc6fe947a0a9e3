"""A residual that is loud in spells is not one disturbance; a steady one is, whatever its colour."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.numerics import Array
from incsvr.tracing.disturbance import disturbance
from incsvr.tracing.spells import spans, spells
from incsvr.tracing.thresholds import SPELL_P_VALUE

N = 2000
STILL = np.zeros((N, 1))


def noise(seed: int) -> Array:
    drawn: Array = np.random.default_rng(seed).standard_t(6.0, N)
    return drawn


@pytest.mark.slow
def test_steady_noise_has_no_spell_more_often_than_the_level_says() -> None:
    named = sum(bool(spells(noise(seed), STILL, 20.0).any()) for seed in range(60))
    assert named <= 3  # of 60 at 0.005: a fourth would come once in 3,700 times
    assert SPELL_P_VALUE == 0.005


@pytest.mark.parametrize("seed", range(3))
def test_a_spell_is_found_where_it_is(seed: int) -> None:
    left = noise(seed)
    left[600:800] *= 3.0
    inside = spells(left, STILL, 20.0)
    assert inside[620:780].mean() > 0.9
    assert inside[:500].mean() + inside[900:].mean() < 0.1
    ((first, last),) = spans(np.linspace(0.0, 0.5 * N, N, endpoint=False), inside, 0.5)
    assert first == pytest.approx(300.0, abs=60.0)
    assert last == pytest.approx(400.0, abs=60.0)


def test_what_the_motion_makes_louder_is_no_spell() -> None:
    """A sweep: the faster it turns, the less exact is a block's equation."""
    moves = np.linspace(0.1, 10.0, N)
    assert not spells(noise(1) * (1.0 + moves), moves[:, None], 20.0).any()


def test_one_outlier_is_no_spell() -> None:
    left = noise(2)
    left[1000] = 300.0
    assert not spells(left, STILL, 20.0).any()


@pytest.mark.parametrize("time", [0.5, 2.0])
def test_a_disturbance_has_its_size_share_and_time(time: float) -> None:
    random, kept = np.random.default_rng(4), np.exp(-0.1 / time)
    left = np.zeros(50_000)
    for k in range(1, left.size):
        left[k] = kept * left[k - 1] + np.sqrt(1.0 - kept**2) * 2.0 * random.normal()
    found = disturbance(left, 0.1, np.full(10, 40.0))
    assert found["torque_rmse"] == pytest.approx(2.0, rel=0.05)
    assert found["share_of_torque"] == pytest.approx(0.05, rel=0.05)
    assert found["correlation_time_s"] == pytest.approx(time, rel=0.15)
