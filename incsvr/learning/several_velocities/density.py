"""Forgetting over several velocities: bins of a range become the density of a cloud."""

from __future__ import annotations

import numpy as np

from incsvr.learning.criteria import Mask
from incsvr.numerics import Array


def forgetting(u: Array, *, capacity: int) -> Mask:
    """Forgetting (Section III-C 2) by a kernel density: the oldest of the densest place goes, until `capacity` stay.

    The density at each vector is the sum of Gaussian kernels of all; the densest place is what lies within one
    bandwidth of the vector where it is largest. The bandwidth is Scott's, n^(−1/(d+4)) standard deviations (Scott,
    Multivariate Density Estimation, 1992, Eq. 6.44), so that nobody has to say how many bins there should be.

    Args:
        u: (n, d) velocities of the vectors, oldest first.
        capacity: how many may stay.

    Returns:
        (n,) mask of those that stay.
    """
    n, d = u.shape
    stays = np.ones(n, dtype=bool)
    if n <= capacity:
        return stays
    bandwidth = n ** (-1.0 / (d + 4.0)) * u.std(axis=0)
    square = np.zeros((n, n))
    for column, width in zip(u.T, bandwidth, strict=True):
        if width > 0.0:
            square += (np.subtract.outer(column, column) / width) ** 2
    near = square <= 1.0
    kernel = np.exp(-0.5 * square)
    density = kernel.sum(axis=1)
    for _ in range(n - capacity):
        densest = int(np.where(stays, density, -np.inf).argmax())
        oldest = int((near[densest] & stays).argmax())
        stays[oldest] = False
        density -= kernel[oldest]
    return stays
