"""How well a vehicle's parameters are known: intervals of 95 % from the scatter between blocks of windows."""

from __future__ import annotations

import numpy as np
from scipy.stats import t as student

from incsvr.numerics import Array
from incsvr.vehicle.fitting import PRIOR_SCALES, Fit, normal_equations

CONFIDENCE = 0.95
"""Confidence of the intervals."""
BLOCK_WINDOWS = 4
"""Windows that count as one observation: what disturbs a vehicle outlasts a window."""
MIN_BLOCKS = 8
"""Fewer blocks than this beyond the number of parameters say little: windows then count one by one."""


def covariance(fitted: Fit) -> tuple[Array, int]:
    """(size, size) covariance of the parameters, and the degrees of freedom of their t distribution.

    It is that of an M-estimator, H⁻¹ (Σ s sᵀ) H⁻¹ with the scores s of blocks of windows, so that errors may be of
    any size and colour within a block.
    """
    count, windows = fitted.parameters.size, fitted.error.shape[0]
    block = BLOCK_WINDOWS if windows // BLOCK_WINDOWS >= count + MIN_BLOCKS else 1
    normal, _ = normal_equations(fitted.slope, fitted.error, fitted.weight)
    bread = np.linalg.inv(normal + np.diag(1.0 / (PRIOR_SCALES * fitted.scale) ** 2))
    weighted = fitted.error * fitted.weight[:, None, :] / fitted.error.shape[1]
    scores = np.einsum("pwca,wca->wp", fitted.slope, weighted)
    blocks = np.arange(windows) // block
    summed = np.stack([np.bincount(blocks, weights=column) for column in scores.T], axis=1)
    number = summed.shape[0]
    freedom = max(number - count, 1)
    meat = summed.T @ summed * (number / freedom)
    return np.asarray(bread @ meat @ bread), freedom


def intervals(fitted: Fit, bounds: tuple[Array, Array]) -> tuple[Array, Array]:
    """Lower and upper ends (size,) each, within the bounds of physics."""
    spread, freedom = covariance(fitted)
    reach = float(student.ppf(0.5 * (1.0 + CONFIDENCE), freedom)) * np.sqrt(np.diag(spread))
    return np.maximum(fitted.parameters - reach, bounds[0]), np.minimum(fitted.parameters + reach, bounds[1])
