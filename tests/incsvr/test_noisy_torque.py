"""A torque that is recorded with lasting noise, under a command that stays at its levels: what feeds on the noise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from incsvr.effects import catalogue
from incsvr.tracing import trace
from incsvr.tracing.run import Array, Run
from incsvr.tracing.weak.alignment import aligned, reread
from incsvr.tracing.weak.hypothesis import nothing, settle
from incsvr.tracing.weak.noise import noise_share
from incsvr.tracing.weak.posing import pose
from incsvr.tracing.weak.validation import Validation
from incsvr.tracing.weak.weak_form import split

INERTIA = 120.0
PERIOD = 0.05
TIME = np.asarray(PERIOD * np.arange(7200), dtype=np.float64)


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


@pytest.mark.parametrize("command", [telegraph, pulses])
def test_a_limit_or_a_dead_band_that_takes_but_noise_is_not_named(command: Callable[[int], Array]) -> None:
    assert trace([recorded(1, command(1))], inertia=INERTIA).effects == ()


def test_a_dead_band_in_the_same_noise_is_named() -> None:
    """And as wide as it is, though the noise crosses its edge: that is told from the command alone."""
    (found,) = trace([recorded(1, pulses(1), width=12.0)], inertia=INERTIA).effects
    assert found.effect == "dead_zone"
    assert found.parameters["half_width_nm"] == pytest.approx(12.0, rel=0.05)


@pytest.mark.parametrize("late", [3, 5])
def test_a_late_thrust_is_found_by_what_the_command_was(late: int) -> None:
    """From the rate side, which knows no noise but is smoothed, it was too late by a tenth, with a limit beside it."""
    (found,) = trace([recorded(3, pulses(3), late=late)], inertia=INERTIA).effects
    assert found.effect == "torque_delay"
    assert found.parameters["delay_s"] == pytest.approx(PERIOD * late, rel=0.04)


@pytest.mark.parametrize("command", [telegraph, pulses])
@pytest.mark.parametrize("memory", [0.0, 0.9])
def test_the_noise_is_read_where_the_command_stays_however_often_it_jumps(
    command: Callable[[int], Array], memory: float
) -> None:
    assert aligned([recorded(2, command(2), memory=memory)], INERTIA, []).signals.share > 0.8


def test_the_noise_is_read_where_the_thrust_comes_late() -> None:
    """It is in the torque when it is recorded: a residual that held it as late as the thrust would tell of none."""
    run = recorded(2, telegraph(2), late=3)
    assert aligned([run], INERTIA, []).signals.share > 0.8
    (found,) = trace([run], inertia=INERTIA).effects
    assert found.effect == "torque_delay"


@pytest.mark.parametrize("known", [False, True])
def test_the_noise_is_read_when_it_is_in_the_residual(known: bool) -> None:
    """A delay that is told from the recorded torque moves its noise, one of a command that is known does not."""
    run = recorded(2, pulses(2), memory=0.0, late=6)
    problem = pose([run], INERTIA, [])
    problem = replace(problem, signals=replace(problem.signals, known=known))
    assert problem.command.plain is not None
    found = settle(problem, [(catalogue()["torque_delay"], (PERIOD * 6,), ())], nothing(problem))
    assert found.terms[0].coefficients[0] == pytest.approx(PERIOD * 6, rel=0.1)
    assert reread([run], problem, found).signals.share > 0.8


def test_a_command_without_noise_has_none() -> None:
    """All the noise is the water's, and no jump of the command may pass for noise of the torque."""
    torque = telegraph(3)
    blocks = split(np.array([0, torque.size]), 4, PERIOD)
    residual = np.random.default_rng(3).normal(size=len(blocks))
    share = noise_share(blocks, torque, residual)
    assert share is not None
    assert share < 0.1


def test_a_gyro_that_is_sampled_slowly_gets_an_answer() -> None:
    """A block of a single sample can grow but by whole samples."""
    slow = recorded(4, telegraph(4))
    run = Run("slow", TIME[::4], slow.yaw_rate[::4], slow.torque[::4], {})
    problem = aligned([run], INERTIA, [])
    assert problem.blocks.period > 0.19


def swept(seed: int) -> Array:
    """One tone, from a period of 50 s to one of 6 s and anew [N m]."""
    part = TIME % 120.0 / 120.0
    cycles = 120.0 / 50.0 * ((50.0 / 6.0) ** part - 1.0) / np.log(50.0 / 6.0)
    return np.asarray(90.0 * np.sin(2.0 * np.pi * cycles + seed))


def wandering(seed: int) -> Array:
    """As a pilot drives: no tones, no levels [N m]."""
    walk = np.cumsum(np.random.default_rng([seed, 0]).normal(size=TIME.size))
    smooth = lfilter([0.02], [1.0, -0.98], walk - np.convolve(walk, np.ones(201) / 201, "same"))
    return np.asarray(60.0 * smooth / np.std(smooth))


def test_a_free_run_is_driven_by_the_command_where_that_is_told() -> None:
    """What else is in the torque turned nothing; a pilot's validation recording is driven by its own torque."""
    problem = aligned([recorded(1, swept(1), memory=0.0)], INERTIA, [])
    assert problem.signals.known
    plain, moved = problem.command.plain, problem.signals.torque
    assert plain is not None
    assert np.std(plain - moved) > 2.0
    alike, otherwise = ([recorded(2, command(2), memory=0.0)] for command in (swept, wandering))
    for runs, known in ((None, True), (alike, True), (otherwise, False)):
        proof = Validation.of(problem, runs)
        assert (proof.validation or problem).signals.known == known
    assert Validation.of(problem, alike)(nothing(problem)) < 0.5 * Validation.of(problem, otherwise)(nothing(problem))
    told = [trace([recorded(1, swept(1), memory=0.0)], inertia=INERTIA, validate=v).notes for v in (alike, otherwise)]
    assert [any("driven by the command" in note for note in notes) for notes in told] == [True, False]
