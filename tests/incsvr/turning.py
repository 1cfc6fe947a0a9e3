"""A vehicle that turns under a jumping command, in moving water, and whatever moment or gain a test adds."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from incsvr.tracing.run import Array, Run
from incsvr.tracing.weak.posing import pose
from incsvr.tracing.weak.problem import Problem

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
    stiffness: float = 0.0, channels: Mapping[str, Array] | None = None,
) -> Problem:  # fmt: skip
    """The equations of I ṙ + 120 r + 700 r|r| = gain τ + outside − k ψ, with noise.

    Args:
        seed: draws the noise: sensors' of 1 N m and 0.0005 rad/s, water's of 10 N m within each step.
        torque: (n,) [N m].
        outside: (n,) a moment that the torque does not know [N m].
        gain: (n,) what becomes of the torque.
        stiffness: k [N m/rad] of a tether that is untwisted where the recording begins.
        channels: further streams, (n,) each.
    """
    random = np.random.default_rng([seed, 1])
    time = instants(torque.size * PERIOD)
    moment = gain * torque + outside + random.normal(0.0, 10.0, time.size)
    rate, now, heading = np.empty(time.size), 0.0, 0.0
    for k, acting in enumerate(moment.tolist()):
        rate[k] = now
        now += PERIOD / INERTIA * (acting - stiffness * heading - 120.0 * now - 700.0 * now * abs(now))
        heading += PERIOD * now
    recorded = dict(channels or {})
    run = Run(
        "turning", time, rate + random.normal(0.0, 5e-4, time.size), torque + random.normal(0.0, 1.0, time.size),
        recorded,
    )  # fmt: skip
    return pose([run], INERTIA, list(recorded), zero_order_hold=True)
