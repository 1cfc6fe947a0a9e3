"""A vehicle that turns under a jumping command, in moving water, and whatever moment or gain a test adds."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from incsvr.numerics import Array
from incsvr.tracing.run import Run

INERTIA = 350.0
"""[kg m²], as declared."""
PERIOD = 0.05


def instants(seconds: float) -> Array:
    return np.asarray(PERIOD * np.arange(round(seconds / PERIOD)), dtype=np.float64)


def command(seed: int, time: Array) -> Array:
    """Jumps every few seconds [N m]."""
    random = np.random.default_rng(seed)
    jumps = np.cumsum(random.uniform(3.0, 12.0, time.size))
    levels: Array = random.uniform(-90.0, 90.0, time.size)[np.searchsorted(jumps, time)]
    return levels


def turning(
    seed: int, torque: Array, *, outside: Array | float = 0.0, gain: Array | float = 1.0,
    answer: float = 0.0, channels: Mapping[str, Array] | None = None,
) -> Run:  # fmt: skip
    """A recording of I ṙ + 120 r + 700 r|r| = gain (τ − answer r) + outside, with noise.

    Args:
        seed: draws the noise: the gyro's of 0.0005 rad/s, water's of 10 N m within each step.
        torque: (n,) [N m].
        outside: (n,) a moment that the torque does not know [N m].
        gain: (n,) what becomes of the torque.
        answer: gain of a controller that brakes the turn that its gyro shows [N m s].
        channels: further streams, (n,) each.
    """
    random = np.random.default_rng([seed, 1])
    time = instants(torque.size * PERIOD)
    water = outside + random.normal(0.0, 10.0, time.size)
    gains, noise = np.broadcast_to(gain, time.shape), random.normal(0.0, 5e-4, time.size)
    rate, applied, now = np.empty(time.size), np.empty(time.size), 0.0
    for k in range(time.size):
        rate[k] = now + noise[k]
        applied[k] = torque[k] - answer * rate[k]
        now += PERIOD / INERTIA * (gains[k] * applied[k] + water[k] - 120.0 * now - 700.0 * now * abs(now))
    return Run("turning", time, rate, applied, dict(channels or {}))
