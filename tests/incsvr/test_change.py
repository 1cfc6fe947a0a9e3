"""The Bayes factor for a change against the densities that define it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from incsvr.learning.policies.change import features, gather, prior, surprise
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
