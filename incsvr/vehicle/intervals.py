"""Intervals of 95 % of a vehicle's parameters, from fits that each lack one block of the recording."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from incsvr.numerics import Array
from incsvr.vehicle.fitting import DEGREES_OF_FREEDOM, PRIOR_SCALES, Fit, normal_equations

CONFIDENCE = 0.95
"""Confidence of the intervals."""
MAX_BLOCKS = 24
"""Blocks that are left out in turns. Each lasts long beside what disturbs a vehicle, and so many leave Student's t near
a normal law: 12 to 32 held the truth alike on simulated vehicles."""


def covariance(fitted: Fit) -> tuple[Array, int]:
    """(size, size) covariance of the parameters, and the degrees of freedom of their t distribution.

    The jackknife over blocks of windows: errors may be of any size and colour within a block, and a block that holds
    much of what shows a parameter counts by that. Each fit without a block is one Newton step from the whole one.
    """
    windows = fitted.error.shape[0]
    number = min(MAX_BLOCKS, windows)
    blocks = np.arange(windows) * number // windows
    curvatures, gradients = zip(*(_of_block(fitted, blocks == k) for k in range(number)), strict=True)
    whole = np.sum(curvatures, axis=0) + np.diag(1.0 / (PRIOR_SCALES * fitted.scale) ** 2)
    moved = np.linalg.solve(whole - np.stack(curvatures), np.stack(gradients)[..., None])[..., 0]
    apart = moved - moved.mean(axis=0)
    return np.asarray(apart.T @ apart * ((number - 1.0) / number)), number - 1


def intervals(fitted: Fit, bounds: tuple[Array, Array]) -> tuple[Array, Array]:
    """Lower and upper ends (size,) each, within the bounds of physics."""
    spread, freedom = covariance(fitted)
    reach = float(student.ppf(0.5 * (1.0 + CONFIDENCE), freedom)) * np.sqrt(np.diag(spread))
    return np.maximum(fitted.parameters - reach, bounds[0]), np.minimum(fitted.parameters + reach, bounds[1])


def _of_block(fitted: Fit, inside: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Curvature (size, size) and slope (size,) of the criterion in some windows.

    Student's criterion bends less than its weights say, because a weight falls as its window's error grows. Where the
    error is so large that the criterion would bend downwards, it counts as straight.
    """
    slope, error, weight = fitted.slope[:, inside], fitted.error[inside], fitted.weight[inside]
    normal, gradient = normal_equations(slope, error, weight)
    along = np.einsum("pwca,wca->pwa", slope, error) / error.shape[1]
    square = np.mean(error**2, axis=1) + 1e-300
    less = weight * np.minimum(2.0 / (DEGREES_OF_FREEDOM * fitted.variance + square), 1.0 / square)
    flat = along.reshape(along.shape[0], -1)
    return normal - (flat * less.ravel()) @ flat.T, gradient
