"""The Bayes factor for a change against the densities that define it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from incsvr.learning.policies.change import ALARM_LOG_ODDS, Evidence, features, gather, prior, surprise, together, weigh
from incsvr.learning.policies.noise import Noise
from incsvr.learning.spread import Spread
from incsvr.numerics import Array


def covariance_of(index: Array, rho: float, sigma: float) -> Array:
    return np.asarray(sigma**2 * rho ** np.abs(np.subtract.outer(index, index)))


@pytest.mark.parametrize("rho", [0.0, 0.8])
def test_surprise_is_the_density_of_the_residuals(rho: float) -> None:
    """−ln N(e; 0, Σ + φ P⁻¹ φᵀ) with Σ of a first-order process from which samples are missing."""
    rng = np.random.default_rng(1)
    index = np.flatnonzero(rng.random(40) > 0.2)
    rate = rng.uniform(-0.2, 0.2, index.size)
    phi = features(rate / 0.25, 400.0 * rate)
    noise = Noise(Spread(0.25), 16.0, rho, 100.0)
    residual = 4.0 * rng.normal(size=index.size)
    evidence = gather(rate, phi, residual, index, noise)
    sigma = covariance_of(index.astype(np.float64), rho, 4.0)
    constant = 0.5 * (np.linalg.slogdet(sigma)[1] + index.size * np.log(2.0 * np.pi))
    for precision in (prior(4.0), 50.0 * prior(4.0)):
        density = multivariate_normal(cov=sigma + phi @ np.linalg.inv(precision) @ phi.T).logpdf(residual)
        assert surprise(evidence, precision) + constant == pytest.approx(-density, rel=1e-9)


def test_evidence_adds_up() -> None:
    rng = np.random.default_rng(2)
    noise = Noise(Spread(0.25), 16.0, 0.0, 100.0)
    rate = rng.uniform(-0.2, 0.2, 60)
    phi, residual = features(rate / 0.25, 400.0 * rate), rng.normal(size=60)
    parts = [
        gather(rate[part], phi[part], residual[part], np.arange(20), noise)
        for part in (slice(0, 20), slice(20, 40), slice(40, 60))
    ]
    whole = gather(rate, phi, residual, np.arange(60), noise)
    np.testing.assert_allclose(together(parts).information, whole.information)
    np.testing.assert_allclose(together(parts).score, whole.score)
    assert together(parts).square == pytest.approx(whole.square)
    assert together(parts).reach == pytest.approx(np.abs(rate).max())


def batch(rng: np.random.Generator, gain: float, noise: Noise) -> Evidence:
    rate = rng.uniform(-0.24, 0.24, 50)
    curve = 110.0 * rate + 1150.0 * rate * np.abs(rate)
    residual = gain * curve + noise.sigma * rng.normal(size=50)
    return gather(rate, features(rate / 0.25, curve), residual, np.arange(50), noise)


def test_a_gain_of_a_tenth_is_seen_and_noise_is_not() -> None:
    rng = np.random.default_rng(3)
    noise = Noise(Spread(0.25), 16.0, 0.0, 250.0)
    free = prior(4.0)
    memory = together([batch(rng, 0.0, noise) for _ in range(10)]).information
    quiet = [weigh([batch(rng, 0.0, noise) for _ in range(4)], memory + free, free).log_factor for _ in range(50)]
    moved = [weigh([batch(rng, 0.11, noise) for _ in range(1)], memory + free, free).log_factor for _ in range(50)]
    assert np.median(quiet) < 0.0
    assert max(quiet) < ALARM_LOG_ODDS
    assert min(moved) > ALARM_LOG_ODDS


def test_what_the_memory_does_not_know_is_no_change() -> None:
    free = prior(4.0)
    evidence = batch(np.random.default_rng(4), 0.5, Noise(Spread(0.25), 16.0, 0.0, 250.0))
    assert weigh([evidence], free, free).log_factor == 0.0


def test_a_batch_without_samples_says_nothing() -> None:
    nothing = np.empty(0)
    evidence = gather(
        nothing, np.empty((0, 6)), nothing, np.empty(0, dtype=np.intp), Noise(Spread(0.25), 16.0, 0.3, 100.0)
    )
    free = prior(4.0)
    assert surprise(evidence, free) == pytest.approx(0.0, abs=1e-12)
    assert weigh([evidence], 9.0 * free, free).log_factor == pytest.approx(0.0, abs=1e-12)
