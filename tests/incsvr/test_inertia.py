"""The inertia from data: true with an honest error where the data tell it, refused where they do not."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.forecasting.over_recordings import free_run, tabulated
from incsvr.model.inertia import estimate_inertia
from incsvr.numerics import Array, Streams

NOISE = 0.01


def truth(rate: Array) -> Array:
    return rate * (2.0 + 1.5 * np.abs(rate))


def run(seed: int, inertia: float = 1.5, duration: float = 30.0, reverse: float = 1.0) -> Streams:
    """A small vehicle under random steps of torque, of which a part acts in reverse."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, duration, 0.04, dtype=np.float64)
    torque = np.repeat(rng.choice([-4.0, -2.0, 0.0, 2.0, 4.0], time.size // 25 + 1), 25)[: time.size]
    acts = np.where(torque < 0.0, reverse * torque, torque)
    rate = free_run(time, acts, 0.0, inertia=inertia, damping=tabulated(truth, 4.0))
    return {"yaw_rate": (time, rate + rng.normal(0.0, NOISE, time.size)), "torque": (time, torque)}


def test_the_inertia_is_found_within_its_standard_error() -> None:
    """Over ten repetitions the errors have the size that the standard errors claim, and no bias."""
    estimates = [estimate_inertia([run(seed)]) for seed in range(10)]
    scores = np.array([(estimate.inertia - 1.5) / estimate.standard_error for estimate in estimates])
    assert 0.4 < np.sqrt(np.mean(scores**2)) < 2.0
    assert abs(np.mean(scores)) < 1.5
    assert all(estimate.standard_error < 0.02 for estimate in estimates)
    assert np.mean([estimate.rmse for estimate in estimates]) == pytest.approx(NOISE, rel=0.1)
    assert not any(estimate.effects for estimate in estimates)


def test_what_the_plain_model_replaces_by_inertia_is_told_and_widens_its_error() -> None:
    estimates = [estimate_inertia([run(seed, duration=60.0, reverse=0.7)]) for seed in range(3)]
    for estimate in estimates:
        assert estimate.effects == ("reverse@yaw_rate",)
        assert abs(estimate.beside - 1.5) < 4.0 * estimate.beside_error < 0.08
        assert abs(estimate.inertia - 1.5) < 1.96 * estimate.standard_error
