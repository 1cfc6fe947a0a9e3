"""A torque that is recorded with lasting noise, under a command that stays at its levels: what feeds on the noise."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from incsvr.tracing import trace
from incsvr.tracing.run import Array, Run
from incsvr.tracing.weak.noise import noise_fraction
from incsvr.tracing.weak.weak_form import split

INERTIA = 120.0
PERIOD = 0.05
TIME = np.asarray(PERIOD * np.arange(5000), dtype=np.float64)


def telegraph(seed: int) -> Array:
    """Between ±80 N m, now and then for less than the vehicle's time scale."""
    random = np.random.default_rng([seed, 0])
    jumps = np.cumsum(random.exponential(1.2, TIME.size) + 0.15)
    return np.asarray(80.0 * (-1.0) ** np.searchsorted(jumps, TIME))


def pulses(seed: int) -> Array:
    """Half of the time at rest [N m]."""
    random = np.random.default_rng([seed, 0])
    jumps = np.cumsum(random.uniform(0.3, 2.0, TIME.size))
    levels = np.where(random.random(TIME.size) < 0.5, 0.0, random.choice([-100.0, -50.0, 50.0, 100.0], TIME.size))
    return np.asarray(levels[np.searchsorted(jumps, TIME)])


def recorded(seed: int, command: Array, width: float = 0.0, memory: float = 0.9, late: int = 0) -> Run:
    """I ṙ + 150 r + 600 r|r| = what a dead band of this half width [N m] leaves of the command, `late` samples later.

    The torque is recorded with noise of 3.5 N m whose autocorrelation over a sample is `memory`, the rate with 0.002
    rad/s; the water is calm.
    """
    random = np.random.default_rng([seed, 1])
    acting = np.sign(command) * np.maximum(np.abs(command) - width, 0.0)
    acting = np.concatenate([np.full(late, acting[0]), acting[: acting.size - late]])
    rate, now = np.empty(TIME.size), 0.0
    for k, moment in enumerate(acting.tolist()):
        rate[k] = now
        for _ in range(10):
            now += 0.1 * PERIOD / INERTIA * (moment - 150.0 * now - 600.0 * now * abs(now))
    noise = lfilter([np.sqrt(1.0 - memory**2)], [1.0, -memory], random.normal(size=TIME.size))
    measured: Array = rate + random.normal(0.0, 0.002, TIME.size)
    return Run("noisy", TIME, measured, np.asarray(command + 3.5 * noise, dtype=np.float64), {})


def test_a_limit_or_a_dead_band_that_takes_but_noise_is_not_named() -> None:
    assert trace([recorded(1, telegraph(1))], inertia=INERTIA).effects == ()


def test_a_dead_band_in_the_same_noise_is_named() -> None:
    """And as wide as it is, though the noise crosses its edge: that is told from the command alone."""
    (found,) = trace([recorded(1, pulses(1), width=12.0)], inertia=INERTIA).effects
    assert found.effect == "dead_zone"
    assert found.parameters["half_width_nm"] == pytest.approx(12.0, rel=0.05)


def test_a_late_thrust_is_found_by_what_the_command_was() -> None:
    """From the rate side, which knows no noise but is smoothed, it was too late by a tenth, with a limit beside it."""
    (found,) = trace([recorded(3, pulses(3), late=5)], inertia=INERTIA).effects
    assert found.effect == "torque_delay"
    assert found.parameters["delay_s"] == pytest.approx(PERIOD * 5, rel=0.04)


def test_a_command_without_noise_has_none() -> None:
    """All the noise is the water's, and no jump of the command may pass for noise of the torque."""
    torque = telegraph(3)
    blocks = split(np.array([0, torque.size]), 4, PERIOD)
    residual = np.random.default_rng(3).normal(size=len(blocks))
    fraction = noise_fraction(blocks, torque, residual)
    assert fraction is not None
    assert fraction < 0.1
