"""A torque that is measured with noise of its own, under a command that stays at its levels."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from incsvr.tracing import trace
from incsvr.tracing.run import Array, Run
from incsvr.tracing.weak.noise import noise_fraction
from incsvr.tracing.weak.weak_form import split

INERTIA, STEP, EVERY = 120.0, 0.005, 10
PERIOD = STEP * EVERY
TIME = np.asarray(STEP * np.arange(50_000), dtype=np.float64)


def telegraph(seed: int) -> Array:
    """Between ±80 N m, now and then for less than the vehicle's time scale."""
    random = np.random.default_rng([seed, 0])
    jumps = np.cumsum(random.exponential(1.2, TIME.size // 20) + 0.15)
    return np.asarray(80.0 * (-1.0) ** np.searchsorted(jumps, TIME))


def pulses(seed: int) -> Array:
    """Half of the time at rest [N m]."""
    random = np.random.default_rng([seed, 0])
    jumps = np.cumsum(random.uniform(0.3, 2.0, TIME.size // 20))
    some = jumps.size + 1
    levels = np.where(random.random(some) < 0.5, 0.0, random.choice([-100.0, -50.0, 50.0, 100.0], some))
    return np.asarray(levels[np.searchsorted(jumps, TIME)])


def recorded(seed: int, command: Array, width: float = 0.0, late: float = 0.0) -> Run:
    """I ṙ + 150 r + 600 r|r| = what a dead band of this half width [N m] leaves of the command, `late` seconds later,
    plus 1.5 N m of water that lasts half a second.

    Jumps fall between two stamps; the torque is measured with white noise of 1 N m, the rate with 0.002 rad/s.
    """
    random, steps = np.random.default_rng([seed, 1]), round(late / STEP)
    acting = np.sign(command) * np.maximum(np.abs(command) - width, 0.0)
    acting = np.concatenate([np.full(steps, acting[0]), acting[: acting.size - steps]])
    water = 1.5 * lfilter([np.sqrt(1.0 - 0.99**2)], [1.0, -0.99], random.normal(size=TIME.size))
    rate, now = np.empty(TIME.size), 0.0
    for k, moment in enumerate((acting + water).tolist()):
        rate[k] = now
        now += STEP / INERTIA * (moment - 150.0 * now - 600.0 * now * abs(now))
    time = TIME[3::EVERY]
    measured: Array = rate[3::EVERY] + random.normal(0.0, 0.002, time.size)
    return Run("noisy", time, measured, command[3::EVERY] + random.normal(0.0, 1.0, time.size), {})


def test_a_limit_or_a_dead_band_that_takes_but_noise_is_not_named() -> None:
    assert trace([recorded(21, telegraph(21))], inertia=INERTIA, torque="measured").effects == ()


def test_a_dead_band_in_the_same_noise_is_named() -> None:
    """And about as wide as it is, though the noise crosses its edge."""
    (found,) = trace([recorded(22, pulses(22), width=12.0)], inertia=INERTIA, torque="measured").effects
    assert found.effect == "dead_zone"
    assert found.parameters["half_width_nm"] == pytest.approx(12.0, rel=0.1)


def test_a_late_thrust_is_found_by_what_the_command_was() -> None:
    """From the rate side, which knows no noise but is smoothed, it was too late by a tenth, with a limit beside it."""
    (found,) = trace([recorded(23, pulses(23), late=0.25)], inertia=INERTIA, torque="measured").effects
    assert found.effect == "torque_delay"
    assert found.parameters["delay_s"] == pytest.approx(0.25, rel=0.04)


def test_a_command_without_noise_has_none() -> None:
    """All the noise is the water's, and no jump of the command may pass for noise of the torque."""
    torque = telegraph(3)[::EVERY]
    blocks = split(np.array([0, torque.size]), 4, PERIOD)
    residual = np.random.default_rng(3).normal(size=len(blocks))
    fraction = noise_fraction(blocks, torque, residual)
    assert fraction is not None
    assert fraction < 0.1
