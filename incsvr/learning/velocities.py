"""The velocities over which damping is learned, and the scale that makes them comparable.

One velocity is the axis's own, with the range of the vehicle as its scale; kernel width and nearness are in its unit.
Every other one is multiplied until its fastest value is as far from rest as the fastest own velocity. So one γ and one
nearness serve for all, whatever their units.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.numerics import Array
from incsvr.signals.samples import Samples


def points(samples: Samples, others: Sequence[str]) -> Array:
    """(n, d) the own velocity and the others, in their units."""
    if not others:
        return samples.yaw_rate[:, None]
    return np.column_stack((samples.yaw_rate, *(samples.channels[name] for name in others)))


def samples_with(time: Array, velocity: Array, damping: Array, others: Sequence[str]) -> Samples:
    """Samples of (n, d) velocities, the own one first."""
    return Samples(time, velocity[:, 0], damping, dict(zip(others, velocity[:, 1:].T, strict=True)))


def distances(x: Array, z: Array) -> Array:
    """(n, m) between (n, d) and (m, d) scaled velocities."""
    if x.shape[1] == 1:
        return np.asarray(np.abs(x - z[:, 0]))
    square = np.zeros((x.shape[0], z.shape[0]))
    for x_k, z_k in zip(x.T, z.T, strict=True):
        difference = np.subtract.outer(x_k, z_k)
        difference *= difference
        square += difference
    return np.asarray(np.sqrt(square))
