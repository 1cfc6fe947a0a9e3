"""The inertia from data: true with an honest error where the data tell it, refused where they do not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.free_run.errors import free_run_rmse
from incsvr.free_run.integrator import free_run, tabulated
from incsvr.free_run.motions import Motion, motions
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


def test_spikes_do_not_move_it() -> None:
    clean = run(3)
    spiked = clean.yaw_rate.copy()
    spiked[::60] += 2.0
    estimate = identify([Motion(clean.torque_time, clean.torque, clean.rate_time, spiked)])
    assert estimate.inertia == pytest.approx(1.5, rel=0.05)


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


def test_a_recording_is_cut_at_the_gaps_of_either_stream() -> None:
    time = np.arange(0.0, 30.0, 0.1, dtype=np.float64)
    rate_time, torque_time = time[(time < 10.0) | (time > 12.0)], time[(time < 20.0) | (time > 20.5)] + 0.03
    found = motions({"yaw_rate": (rate_time, rate_time), "torque": (torque_time, torque_time)}, gap=0.3)
    spans = [(part.rate_time[0], part.rate_time[-1]) for part in found]
    np.testing.assert_allclose(spans, [(0.0, 9.9), (12.1, 19.9), (20.7, 29.9)], atol=1e-6)
    assert motions({"yaw_rate": (time[:5], time[:5]), "torque": (time, time)}, gap=0.3) == []


def test_the_free_run_of_the_truth_leaves_the_sensors_noise() -> None:
    rmse = free_run_rmse([run(1), run(2)], 1.5, truth)
    assert rmse == pytest.approx(NOISE, rel=0.3)
    worse = free_run_rmse([run(1), run(2)], 2.0, truth)
    assert worse is not None
    assert worse > 2.0 * NOISE
    assert free_run_rmse([run(1)], 1.5, lambda rate: -5.0 * rate) is None
    assert free_run_rmse([], 1.5, truth) is None
