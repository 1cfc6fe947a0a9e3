"""A dead band must be heard: inside it the torque moves more than its noise, and the vehicle does not."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from incsvr.effects import catalogue
from incsvr.tracer.alignment import with_share
from incsvr.tracer.hypothesis import Hypothesis, nothing, settle
from incsvr.tracer.posing import pose
from incsvr.tracer.problem import Problem
from incsvr.tracer.run import Array, Run
from incsvr.tracer.silent import but_noise
from tests.incsvr.turning import INERTIA, PERIOD, instants

NOISE = 3.5
"""[N m] of the torque's sensor, of which a part lasts half a second."""


def stick(seed: int, size: int) -> Array:
    """A joystick that is let go half of the time: the command then fades to nothing."""
    random = np.random.default_rng(seed)
    pushed = np.where(random.random(size) < 0.5, random.uniform(-90.0, 90.0, size), 0.0)
    moved: Array = lfilter([0.08], [1.0, -0.92], np.repeat(pushed, 120)[:size])
    return moved


def let_go(seed: int, band: float) -> Problem:
    """A vehicle under such a command with a dead band of that half width, all noise in the torque's sensor."""
    random = np.random.default_rng([seed, 1])
    time = instants(720.0)
    command = stick(seed, time.size)
    rate, now = np.empty(time.size), 0.0
    for k, acting in enumerate((command - np.clip(command, -band, band)).tolist()):
        rate[k] = now
        now += PERIOD / INERTIA * (acting - 120.0 * now - 700.0 * now * abs(now))
    lasting = lfilter([np.sqrt(1.0 - 0.9**2)], [1.0, -0.9], random.normal(0.0, NOISE, time.size))
    recorded = Run("stick", time, rate + random.normal(0.0, 2e-4, time.size), command + lasting, {})
    return with_share(pose([recorded], INERTIA, [], held=True), 1.0)


def with_band(problem: Problem, width: float, form: str) -> Hypothesis:
    band = catalogue()[f"dead_zone/{form}"]
    return settle(problem, [(band, (width,), ())], nothing(problem))


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_band_that_takes_but_the_noise_of_a_torque_at_rest_is_none(seed: int) -> None:
    """The equation is much the better for it, as a torque at rest then needs no noise."""
    problem = let_go(seed, 0.0)
    found, plain = with_band(problem, 1.2 * NOISE, "step"), nothing(problem)
    assert found.criterion > plain.criterion + 40.0
    assert but_noise(problem, found, plain, 0)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_one_in_which_the_command_moves_is_heard(seed: int) -> None:
    problem = let_go(seed, 9.0)
    assert not but_noise(problem, with_band(problem, 9.0, "shifted"), nothing(problem), 0)


def test_a_narrow_one_is_seen_where_the_vehicle_moves() -> None:
    """The command rests too long to be heard inside; outside all of it falls short by the half width."""
    problem = let_go(2, 5.0)
    assert not but_noise(problem, with_band(problem, 5.0, "shifted"), nothing(problem), 0)


def test_an_effect_that_lets_something_through_everywhere_is_not_asked() -> None:
    problem = let_go(0, 0.0)
    bias = settle(problem, [(catalogue()["bias_torque"], (), ())], nothing(problem))
    assert not but_noise(problem, bias, nothing(problem), 0)
