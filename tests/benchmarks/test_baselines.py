"""The baselines: each right where the truth is known, all behind one interface."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.baselines import (
    AdaptiveIdentifier,
    Baseline,
    Data,
    LeastSquares,
    LeastSquaresSVR,
    NeuralNetwork,
    OfflineSVR,
    RecursiveLeastSquares,
    TotalLeastSquares,
)
from incsvr.forecasting.over_recordings import free_run, tabulated
from incsvr.numerics import Array
from incsvr.signals.samples import Samples

RATES = np.linspace(-0.22, 0.22, 45, dtype=np.float64)


def truth(rate: Array) -> Array:
    return rate * (120.0 + 900.0 * np.abs(rate))


def data(duration: float, noise: float = 0.0, factor: float = 1.0) -> Data:
    """A vehicle of 350 kg m² whose damping is linear + quadratic, driven by a sinusoid."""
    time = np.arange(0.0, duration, 0.05, dtype=np.float64)
    torque = 80.0 * np.sin(2.0 * np.pi * time / 40.0)
    rate = free_run(time, torque, 0.0, inertia=350.0, damping=tabulated(lambda r: factor * truth(r), 0.5))
    scatter = np.random.default_rng(1).normal(0.0, noise, time[::10].size)
    return Data(Samples(time[::10], rate[::10], factor * truth(rate[::10]) + scatter), time, rate, torque)


def worst(baseline: Baseline, learned: Data) -> float:
    """Largest error of the learned curve [N m]."""
    return float(np.abs(baseline.fit(learned)(RATES) - truth(RATES)).max())


@pytest.mark.parametrize(
    ("baseline", "duration", "bound"),
    [
        (OfflineSVR(epsilon=0.1), 80.0, 1.0),
        (LeastSquares(), 80.0, 1e-9),
        (TotalLeastSquares(), 80.0, 1e-9),
        (RecursiveLeastSquares(), 80.0, 1e-3),
        (AdaptiveIdentifier(), 3200.0, 1.0),  # a gradient takes long to tell r from r|r|
    ],
)
def test_without_noise_the_curve_is_found(baseline: Baseline, duration: float, bound: float) -> None:
    assert worst(baseline, data(duration)) < bound


def test_total_least_squares_bears_a_noisy_yaw_rate() -> None:
    """Least squares then reads the damping too low; total least squares knows why."""
    clean = data(4000.0, noise=4.0)
    noise = np.random.default_rng(2).normal(0.0, 0.03, len(clean.samples))
    noisy = replace(clean, samples=replace(clean.samples, yaw_rate=clean.samples.yaw_rate + noise))
    assert worst(LeastSquares(), noisy) > 2.0
    assert worst(TotalLeastSquares(rate_noise=0.03), noisy) < 0.5 * worst(LeastSquares(), noisy)


@pytest.mark.slow
@pytest.mark.parametrize("method", [LeastSquaresSVR(), NeuralNetwork()])
def test_scikit_learns_methods_are_near_where_they_were_taught(method: Baseline) -> None:
    assert 0.01 < worst(method, data(300.0, noise=4.0)) < 6.0
