"""Damping over several velocities as a Gaussian process: a length for each, by the greatest marginal likelihood."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

from incsvr.numerics import Array

Predictor = Callable[[Array], Array]
"""Velocities (n, d) → damping (n,)."""


def gaussian_process(velocity: Array, damping: Array, most: int | None = None) -> Predictor:
    """Fitted to velocities (n, d) and their damping (n,); where `most` is given, to so many of them, evenly taken."""
    count = len(damping) if most is None else min(most, len(damping))
    chosen = np.unique(np.linspace(0, len(damping) - 1, count).astype(int))
    scale, level = np.maximum(velocity.std(axis=0), 1e-12), max(float(damping.std()), 1e-12)
    lengths = RBF(np.ones(scale.size), (0.1, 100.0))
    kernel = ConstantKernel(1.0, (1e-3, 1e3)) * lengths + WhiteKernel(0.1, (1e-4, 1e1))
    process = GaussianProcessRegressor(kernel)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # a length at its bound is an answer
        process.fit(velocity[chosen] / scale, damping[chosen] / level)
    return lambda asked: np.asarray(level * process.predict(asked / scale))
