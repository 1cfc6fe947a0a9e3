"""A controller is seen in how its torque answers the rate, and what it does to the noise is in the likelihood."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from incsvr.effects import catalogue
from incsvr.tracing.run import Array, Run
from incsvr.tracing.weak.feedback import controller_gain
from incsvr.tracing.weak.hypothesis import nothing, settle
from incsvr.tracing.weak.posing import pose
from incsvr.tracing.weak.problem import Problem
from incsvr.tracing.weak.weak_form import split
from simulator import recordings
from simulator.trace import runs_of

INERTIA, DRAG, PERIOD, SIZE = 350.0, 160.0, 0.05, 8
N = 16_000


def turned(seed: int, gain: float, *, late: int = 0, fast: bool = False) -> tuple[Array, Array]:
    """Torque and rate of a vehicle in water that pushes; with a gain the torque is a controller's.

    The reference (or, in open loop, the command) is steps rounded off, or noise as fast as the blocks; `late` is the
    delay of the thrust in samples.
    """
    random = np.random.default_rng(seed)
    course = np.repeat(random.normal(size=N // 200 + 1), 200)[:N]
    if fast:
        course = np.convolve(random.normal(size=N), np.ones(SIZE) / np.sqrt(SIZE), "same")
    water = 3.0 * random.normal(size=N) / np.sqrt(PERIOD)
    torque, rate = np.zeros(N), np.zeros(N)
    smooth = 0.0
    for k in range(N - 1):
        smooth += PERIOD / 1.0 * (course[k] - smooth)
        asked = course[k] if fast else smooth
        torque[k] = gain * (0.2 * asked - rate[k]) if gain else 30.0 * asked
        thrust = torque[max(k - late, 0)]
        rate[k + 1] = rate[k] + PERIOD / INERTIA * (thrust + water[k] - DRAG * rate[k])
    torque[-1] = torque[-2]
    return torque, rate


def read(torque: Array, rate: Array, late: int = 0) -> float:
    """The gain as read beside the true model, whose delay is known."""
    blocks = split(np.array([0, N]), SIZE, PERIOD)
    thrust = np.concatenate([np.full(late, torque[0]), torque[: N - late]])
    residual = blocks.mean(thrust) - INERTIA * blocks.slope(rate) - DRAG * blocks.mean(rate)
    return controller_gain(blocks, torque, rate, residual, INERTIA)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_controllers_gain_is_read(seed: int) -> None:
    assert read(*turned(seed, 600.0)) == pytest.approx(600.0, rel=0.1)


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("fast", [False, True])
def test_an_open_loop_has_none(seed: int, fast: bool) -> None:
    assert read(*turned(seed, 0.0, fast=fast)) == 0.0


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_late_thrust_under_a_fast_command_is_no_controller(seed: int) -> None:
    """It turns the vehicle against the command of the moment, but what the water does nobody answers."""
    torque, rate = turned(seed, 0.0, late=SIZE, fast=True)
    pushed, came = (np.diff(values.reshape(-1, SIZE).mean(axis=1), 4) for values in (torque, rate))
    assert np.corrcoef(pushed, came)[0, 1] < -0.1
    assert read(torque, rate, late=SIZE) == 0.0


@pytest.mark.parametrize("run", ["run_04", "run_05"])
def test_measured_levels_of_thrust_are_an_open_loop(measured: Path, run: str) -> None:
    """Its thrust keeps its value in most blocks. Differences over ten of them hold the jumps between, and the thrust
    comes late: it would pass for a controller of 17 to 25 N m s/rad."""
    recording = recordings.read(measured / "bluerov" / f"{run}.csv")
    assert not pose(runs_of([recording]), 1.125, []).closed_loop


@pytest.mark.parametrize("seed", [4, 5, 6])
@pytest.mark.parametrize("effect", ["torque_delay", "torque_lag/moment"])
def test_what_a_controller_answers_is_no_evidence(seed: int, effect: str) -> None:
    """It answers the water within the block: to a likelihood that ignores it, the thrust seems to come late."""
    torque, rate = turned(seed, 700.0)
    seen = rate + 5e-4 * np.random.default_rng(seed).normal(size=N)
    problem = pose([Run("loop", PERIOD * np.arange(N, dtype=np.float64), seen, torque, {})], INERTIA, [])
    assert problem.closed_loop
    known, ignored = (gained(each, effect) for each in (problem, replace(problem, feedback=0.0)))
    assert ignored > 40.0
    assert known < 0.5 * ignored


def gained(problem: Problem, effect: str) -> float:
    """2 Δℓ of an effect alone."""
    base = nothing(problem)
    found = settle(problem, [(catalogue()[effect], (0.1,), ())], base)
    return 2.0 * (found.fit.log_likelihood - base.fit.log_likelihood)
