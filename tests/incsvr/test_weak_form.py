"""Blocks, their derivative and the whitened regression."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from incsvr.effects import Signals
from incsvr.tracing.run import Array, Run
from incsvr.tracing.weak.posing import pose
from incsvr.tracing.weak.weak_form import derivative, split
from incsvr.tracing.weak.whitening import fit


def test_a_block_holds_the_mean_and_the_slope_exactly() -> None:
    blocks = split(np.array([0, 101, 202]), 10, 0.1)
    ramp = np.concatenate([0.1 * np.arange(101), 5.0 + 0.2 * np.arange(101)])
    assert len(blocks) == 20
    np.testing.assert_allclose(blocks.slope(ramp)[[0, 19]], [1.0, 2.0])
    np.testing.assert_allclose(blocks.mean(ramp)[0], 0.5)
    assert blocks.with_history.size == 20 - 2 * 3  # an AR(3) needs three predecessors in the same run


def test_the_beginning_of_a_run_is_in_no_block() -> None:
    """What thrust and water held at the start is unknown; of a short run no more than a fiftieth is given up for it."""
    blocks = split(np.array([0, 10_001, 10_502]), 10, 0.1, settling=5.0)
    assert blocks.first[0] == 50
    assert blocks.first[blocks.start[1]] == 10_001 + 10
    held = blocks.spread(np.ones(len(blocks)), 10_502)
    np.testing.assert_array_equal(np.flatnonzero(held[:10_001] == 0.0), np.arange(50))


def test_what_two_blocks_share_holds_the_mean_of_theirs() -> None:
    blocks = split(np.array([0, 9, 18]), 4, 0.1)
    held = blocks.spread(np.array([1.0, 3.0, 10.0, 20.0]), 18)
    np.testing.assert_array_equal(held[:9], [1.0, 1.0, 1.0, 1.0, 2.0, 3.0, 3.0, 3.0, 3.0])
    assert held[9] == 10.0  # the next run's first sample is shared with nobody


def test_every_block_is_averaged_by_the_trapezoid_rule_whatever_the_runs() -> None:
    """One run begins with samples in no block, one is shorter than a block."""
    runs = np.array([0, 2_003, 2_008, 2_100], dtype=np.intp)
    blocks = split(runs, 8, 0.1, settling=2.0)
    values = np.random.default_rng(0).normal(size=(2_100, 3))
    for k, first in enumerate(blocks.first):
        expected = np.trapezoid(values[first : first + 9], axis=0) / 8
        np.testing.assert_allclose(blocks.mean(values)[k], expected, atol=1e-12)
    np.testing.assert_allclose(blocks.mean(values[:, 0]), blocks.mean(values)[:, 0])
    assert blocks.mean(values[:, :0]).shape == (len(blocks), 0)
    held = blocks.spread(blocks.mean(values[:, 1]), 2_100)
    np.testing.assert_array_equal(held[blocks.first + 4], blocks.mean(values[:, 1]))
    assert not np.any(held[2_003:2_008])


@pytest.mark.parametrize("delay", [0.0, 0.1, 0.13, -0.27, -4.0, 1e3])
def test_a_signal_at_another_time_is_linear_between_its_samples(delay: float) -> None:
    start, step = np.array([0, 40, 100]), 0.1
    values = np.random.default_rng(1).normal(size=100)
    time = np.linspace(0.0, 99 * step, 100)
    later = Signals(step, start, time, values, values).later(values, delay)
    for run in (slice(0, 40), slice(40, 100)):
        np.testing.assert_allclose(later[run], np.interp(time[run] + delay, time[run], values[run]), atol=1e-9)


@pytest.mark.parametrize("sigma", [1.5, 4.0])
@pytest.mark.parametrize("power", [1, 2, 3, 4])
def test_the_derivative_is_exact_for_polynomials_away_from_the_ends(power: int, sigma: float) -> None:
    """Up to the fourth power: a plain Gaussian would add 3 σ² to the slope of the third."""
    x = np.linspace(-1.0, 1.0, 201)
    inside = slice(int(5 * sigma) + 1, -int(5 * sigma) - 1)
    slope = derivative(x**power, np.array([0, 201]), sigma) / (x[1] - x[0])
    np.testing.assert_allclose(slope[inside], (power * x ** (power - 1))[inside], atol=2e-4)


def test_the_derivative_of_a_ramp_is_exact_up_to_the_ends_of_each_run() -> None:
    ramp = np.concatenate([np.arange(50.0), 100.0 - 2.0 * np.arange(50.0)])
    slope = derivative(ramp, np.array([0, 50, 100]), 4.0)
    np.testing.assert_allclose(slope, np.repeat([1.0, -2.0], 50), rtol=1e-3)


def coloured(n: int, rho: float, seed: int) -> Array:
    noise: Array = lfilter([1.0], [1.0, -rho], np.random.default_rng(seed).normal(size=n))
    return noise


def test_the_regression_is_calibrated_under_autocorrelation_and_outliers() -> None:
    """Twice the log likelihood ratio of an idle column is χ² of one degree, though noise has memory and outliers."""
    blocks = split(np.array([0, 801]), 1, 1.0)
    gains = []
    for seed in range(60):
        random = np.random.default_rng(seed)
        noise = coloured(800, 0.9, 1000 + seed) + (random.random(800) < 0.01) * random.normal(0.0, 10.0, 800)
        idle = coloured(800, 0.8, 2000 + seed)
        base = np.column_stack([np.ones(800), np.linspace(-1.0, 1.0, 800)])
        without = fit(noise, base, blocks).log_likelihood
        gains.append(2.0 * (fit(noise, np.column_stack([base, idle]), blocks).log_likelihood - without))
    assert np.median(gains) < 1.5  # of χ²: 0.45
    assert np.mean(np.array(gains) > 6.63) <= 0.1  # of χ²: 0.01


def test_a_loop_that_swings_within_a_few_samples_has_no_block_for_each_of_them() -> None:
    random, time = np.random.default_rng(0), np.linspace(0.0, 200.0, 4001)
    phase = 2.0 * np.pi * 0.8 * time + np.cumsum(random.normal(0.0, 0.1, time.size))
    rate: Array = np.sin(phase)
    torque = np.gradient(rate, time) + 0.5 * rate + random.normal(0.0, 0.3, time.size)
    posed = pose([Run("swinging", time, rate, torque, {})], 1.0, [])
    assert posed.signals.scale < 0.3
    assert 1 < posed.blocks.size <= 3
