"""The tracked noise."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.learning.learner import Settings
from incsvr.learning.policies.noise import HORIZON_SAMPLES, Noise
from tests.incsvr.learning import Policy, drag, policies, run, stream

STILL = Noise.start((-0.25, 0.25))
"""Before the first batch."""


def track(residual: np.ndarray[tuple[int], np.dtype[np.float64]], noise: Noise | None = None) -> Noise:
    noise = noise or STILL
    for first in range(0, residual.size, 50):
        part = residual[first : first + 50]
        noise = noise.after(part, np.arange(part.size), np.zeros(part.size))
    return noise


def coloured(rng: np.random.Generator, n: int, rho: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    noise = rng.normal(size=n)
    for i in range(1, n):
        noise[i] = rho * noise[i - 1] + np.sqrt(1.0 - rho**2) * noise[i]
    return noise


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.8])
def test_level_and_colour_are_found(rho: float) -> None:
    found = [track(4.0 * coloured(np.random.default_rng(seed), 1000, rho)) for seed in range(20)]
    assert np.mean([noise.sigma for noise in found]) == pytest.approx(4.0, rel=0.15)
    assert np.mean([noise.correlation for noise in found]) == pytest.approx(rho, abs=0.08)


def test_a_loud_time_is_forgotten() -> None:
    rng = np.random.default_rng(2)
    noise = track(40.0 * rng.normal(size=500))
    assert noise.seen == HORIZON_SAMPLES
    assert track(0.4 * rng.normal(size=750), noise).sigma == pytest.approx(0.4, rel=0.5)


def test_missing_samples_are_no_neighbours() -> None:
    residual = np.tile([1.0, -1.0], 25)
    assert STILL.after(residual, np.arange(50), np.zeros(50)).correlation == 0.0  # −1, bounded at 0
    assert STILL.after(np.ones(50), np.arange(50), np.zeros(50)).correlation == pytest.approx(0.95)  # 1, bounded
    assert STILL.after(np.ones(50), 2 * np.arange(50), np.zeros(50)).correlation == 0.0


@policies
def test_a_served_sigma_follows_the_rate(policy: Policy) -> None:
    samples = stream(21, 700, wild=0.0)
    noise = samples.damping - drag(samples.yaw_rate)
    samples.damping[:] = drag(samples.yaw_rate) + noise * (0.5 + 4.0 * np.abs(samples.yaw_rate))
    model = run(Settings(policy=policy), samples)[0].model
    quiet, loud = model.predict([0.02, 0.23]).sigma
    assert 1.6 < quiet < 3.5
    assert 4.5 < loud < 8.0
