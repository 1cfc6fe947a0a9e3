"""The inertia from data: true with an honest error where the data tell it, refused where they do not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.free_run.integrator import free_run, tabulated
from incsvr.free_run.motions import Motion
from incsvr.free_run.output_error import identify
from incsvr.numerics import Array

NOISE = 0.01


def truth(rate: Array) -> Array:
    return rate * (2.0 + 1.5 * np.abs(rate))


def run(seed: int, inertia: float = 1.5, duration: float = 30.0) -> Motion:
    """A small vehicle under random steps of torque."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, duration, 0.04, dtype=np.float64)
    torque = np.repeat(rng.choice([-4.0, -2.0, 0.0, 2.0, 4.0], time.size // 25 + 1), 25)[: time.size]
    rate = free_run(time, torque, 0.0, inertia=inertia, damping=tabulated(truth, 4.0))
    return Motion(time, torque, time, rate + rng.normal(0.0, NOISE, time.size))


def test_the_inertia_is_found_within_its_standard_error() -> None:
    """Over ten repetitions the errors have the size that the standard errors claim, and no bias."""
    estimates = [identify([run(seed)]) for seed in range(10)]
    scores = np.array([(estimate.inertia - 1.5) / estimate.standard_error for estimate in estimates])
    assert 0.4 < np.sqrt(np.mean(scores**2)) < 2.0
    assert abs(np.mean(scores)) < 1.5
    assert all(estimate.standard_error < 0.02 for estimate in estimates)
    assert np.mean([estimate.rmse for estimate in estimates]) == pytest.approx(NOISE, rel=0.1)


def steady(torque: float) -> Motion:
    time = np.arange(0.0, 20.0, 0.05, dtype=np.float64)
    return Motion(time, np.full(time.size, torque), time, np.random.default_rng(0).normal(0.3, NOISE, time.size))


UNMOVED = replace(run(1), yaw_rate=np.random.default_rng(0).normal(0.0, 0.5, run(1).yaw_rate.size))
"""A rate that ignores the torque."""


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ([], "inertia cannot be estimated"),
        ([steady(0.0)], "inertia cannot be estimated"),
        ([steady(3.0)], "inertia cannot be estimated"),
        ([UNMOVED], "no free run follows"),
    ],
    ids=["nothing", "at rest", "steady", "ignored"],
)
def test_motion_that_does_not_tell_it_is_refused(given: list[Motion], sentence: str) -> None:
    with pytest.raises(BadInput, match=sentence):
        identify(given)
