"""Sample sets of the kind the learner trains on: old vectors over the whole range beside a stretch of a sinusoid."""

from __future__ import annotations

import numpy as np

from incsvr.numerics import Array


def yaw_samples(seed: int, old: int = 60, new: int = 50, noise: float = 4.0) -> tuple[Array, Array]:
    """x (n,) [rad/s] and y (n,) [N m] with n = old + new."""
    rng = np.random.default_rng(seed)
    phase = rng.uniform(0.0, 2.0 * np.pi)
    x_old = 0.25 * np.sin(rng.uniform(0.0, 2.0 * np.pi, old))
    x_new = 0.25 * np.sin(phase + np.linspace(0.0, 1.2, new)) + rng.normal(size=new) * 0.002
    x = np.concatenate([x_old, x_new])
    return x, 1300.0 * x * np.abs(x) + 40.0 * x + noise * rng.normal(size=x.size)
