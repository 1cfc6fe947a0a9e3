"""The velocities over which damping is learned, and the scale that makes them comparable.

One velocity is the axis's own, with the range of the vehicle as its scale; kernel width and nearness are in its unit.
Every other one is multiplied until its fastest value is as far from rest as the fastest own velocity. So one γ and one
nearness serve for all, whatever their units.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from incsvr.numerics import Array
from incsvr.signals.samples import Samples

MIN_FASTEST = 1e-6
"""Fastest value of a velocity that never moved [m/s] or [rad/s]: no scale is divided by zero."""
FASTEST_QUANTILE = 0.98
"""Quantile of a batch's |velocity| that counts as its fastest: one outlier must not be the scale."""


def points(samples: Samples, others: Sequence[str]) -> Array:
    """(n, d) the own velocity and the others, in their units."""
    return np.column_stack((samples.yaw_rate, *(samples.channels[name] for name in others)))


def fastest_seen(before: Array, velocity: Array, configured: Mapping[str, float], others: Sequence[str]) -> Array:
    """(d − 1,) the fastest value of each other velocity: as configured, or the fastest that was driven so far.

    Args:
        before: (d − 1,) the same from before.
        velocity: (n, d) of a batch, n ≥ 1.
        configured: by name.
        others: names of the d − 1 others.
    """
    driven = np.quantile(np.abs(velocity[:, 1:]), FASTEST_QUANTILE, axis=0)
    grown = np.maximum(np.maximum(before, driven), MIN_FASTEST)
    return np.array([configured.get(name, float(own)) for name, own in zip(others, grown, strict=True)])


def samples_with(time: Array, velocity: Array, damping: Array, others: Sequence[str]) -> Samples:
    """Samples of (n, d) velocities, the own one first."""
    return Samples(time, velocity[:, 0], damping, dict(zip(others, velocity[:, 1:].T, strict=True)))


def distances(x: Array, z: Array) -> Array:
    """(n, m) between (n, d) and (m, d) scaled velocities."""
    square = np.zeros((x.shape[0], z.shape[0]))
    for x_k, z_k in zip(x.T, z.T, strict=True):
        difference = np.subtract.outer(x_k, z_k)
        difference *= difference
        square += difference
    return np.asarray(np.sqrt(square))
