"""The white noise of a stream, and the time within which it changes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.numerics import Array, robust_deviation


def white_noise(third: Array) -> float:
    """Deviation of white noise from its third differences (n,), which no motion survives; in the stream's unit."""
    return robust_deviation(third) / float(np.sqrt(20.0))


def time_scale(grids: Sequence[Array], period: float) -> float:
    """The lag [s] at which the autocorrelation of a signal falls below one half, over all its pieces together.

    Args:
        grids: pieces (n,) of the signal, each in even steps.
        period: of the steps [s].
    """
    mean = float(np.mean(np.concatenate(grids)))
    length = max(grid.size for grid in grids)
    covariance, count = np.zeros(length), np.zeros(length)
    for grid in grids:
        spectrum = np.abs(np.fft.rfft(grid - mean, 2 * grid.size)) ** 2
        covariance[: grid.size] += np.fft.irfft(spectrum)[: grid.size]
        count[: grid.size] += np.arange(grid.size, 0, -1)
    correlation = covariance / count / max(covariance[0] / count[0], 1e-300)
    below = np.flatnonzero(correlation < 0.5)
    return period * float(below[0] if below.size else length // 2)
