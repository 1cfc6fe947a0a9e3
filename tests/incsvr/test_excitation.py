"""Motion that the water makes is no evidence about damping, and what is served says what is left."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from incsvr.learning.learner import Iteration, Settings, State, start, step
from incsvr.numerics import Array
from incsvr.signals import SignalSettings, synchronise
from incsvr.signals.samples import Samples
from simulator import leng
from tests.incsvr.learning import Policy, batches, policies, run

INERTIA, PERIOD = 350.0, 0.1
WATER = 3.0
"""Deviation of the water's moment [N m]; it lasts two seconds."""


def samples(
    ask: Callable[[float], float], gain: float, *, seconds: float, seed: int, declared: float = INERTIA
) -> Samples:
    """What Leng's log gives under a rate control of this gain [N m s/rad] that is asked for the yaw rate ask(t), where
    an inertia [kg m²] is declared."""
    rng = np.random.default_rng(seed)
    time = PERIOD * np.arange(round(seconds / PERIOD), dtype=np.float64)
    rate: Array = np.zeros(time.size)
    torque: Array = np.zeros(time.size)
    r, water, kept = 0.0, 0.0, np.exp(-PERIOD / 10.0 / 2.0)
    for k, t in enumerate(time.tolist()):
        asked = ask(t)
        rate[k] = r + 0.0005 * rng.normal()
        torque[k] = leng.damping(asked) + gain * (asked - rate[k])
        for kick in rng.normal(size=10):
            water = kept * water + WATER * np.sqrt(1.0 - kept**2) * kick
            r += PERIOD / 10.0 / INERTIA * (torque[k] + water - leng.damping(r))
    settings = SignalSettings(inertia=declared, smoothing=0.3, gap=0.5, sample_period=1.0, lateness=0.0)
    return synchronise(settings, {"yaw_rate": (time, rate), "torque": (time, torque)})[0]


@cache
def holding(seconds: float = 600.0, seed: int = 1, declared: float = INERTIA) -> Samples:
    """A heading is held: all motion is the water's, and the torque answers it."""
    return samples(lambda t: 0.0, 400.0, seconds=seconds, seed=seed, declared=declared)


@cache
def surveying(seconds: float = 1200.0, seed: int = 2) -> Samples:
    """Legs of 80 s, then turns of 20 s at 0.12 or 0.2 rad/s, to and fro."""

    def ask(t: float) -> float:
        leg = int(t // 100.0)
        return (-1.0) ** leg * (0.12, 0.2)[leg // 2 % 2] if t % 100.0 > 80.0 else 0.0

    return samples(ask, 400.0, seconds=seconds, seed=seed)


def after(samples: Samples, time: float) -> Samples:
    return Samples(samples.time + time, samples.yaw_rate, samples.damping)


def driven(iterations: list[Iteration]) -> float:
    undriven = sum(len(iteration.undriven) for iteration in iterations)
    return 1.0 - undriven / (50 * len(iterations))


@policies
def test_a_vehicle_that_holds_its_heading_teaches_nothing(policy: Policy) -> None:
    state, iterations = run(Settings(policy=policy), holding())
    assert not state.model.is_trained
    assert not any(iteration.trained for iteration in iterations)


@policies
def test_motion_that_the_water_makes_leaves_the_curve_as_it_was(policy: Policy) -> None:
    settings = Settings(policy=policy)
    learned, _ = run(settings, surveying())
    state = learned
    for batch in batches(after(holding(), 1200.0)):
        state, _ = step(settings, state, batch)
    rates = np.linspace(-0.2, 0.2, 9)
    moved = state.model.predict(rates).damping - learned.model.predict(rates).damping
    assert np.abs(moved).max() < 0.5 * WATER


@policies
def test_a_survey_teaches_its_turns_and_no_leg_drives_the_vehicle(policy: Policy) -> None:
    state, iterations = run(Settings(policy=policy), surveying())
    assert driven(iterations) < 0.5
    rates = np.concatenate([np.linspace(-0.2, -0.02, 10), np.linspace(0.02, 0.2, 10)])
    said, true = state.model.predict(rates), leng.damping(rates)
    assert (np.abs(said.damping - true) <= np.maximum(0.1 * np.abs(true), 1.5 * WATER)).all()
    assert (np.abs(said.damping - true) <= 3.0 * said.doubt).all()
    assert (said.damping * np.sign(rates) >= -1.96 * said.doubt).all()


def test_the_papers_experiment_is_evidence_nearly_throughout() -> None:
    _, iterations = run(Settings(), leng.experiment(5).T1)
    assert driven(iterations) > 0.96


@pytest.mark.parametrize("wrong", [0.4, 2.5])
def test_a_wrong_inertia_makes_no_motion_the_waters(wrong: float) -> None:
    """At a period of 12 s the share of the inertia that is wrong is as large as all damping."""

    def ask(t: float) -> float:
        return float(0.2 * np.sin(2.0 * np.pi * t / 12.0))

    swinging = samples(ask, 400.0, seconds=600.0, seed=7, declared=wrong * INERTIA)
    assert driven(run(Settings(), swinging)[1]) > 0.96
    assert not run(Settings(), holding(declared=wrong * INERTIA))[0].model.is_trained


@policies
def test_turns_that_are_held_for_long_are_learned_each_at_its_rate(policy: Policy) -> None:
    """Six rates, each held for 150 s by a stiff control: all that the rate does about them is the water's."""
    held = (0.1, -0.15, 0.2, -0.05, 0.15, -0.1)
    stream = samples(lambda t: held[int(t // 150.0) % 6], 1500.0, seconds=1800.0, seed=8)
    model = run(Settings(policy=policy), stream)[0].model
    true = leng.damping(np.array(held))
    assert (np.abs(model.predict(held).damping - true) <= np.maximum(0.1 * np.abs(true), 1.5 * WATER)).all()


@policies
def test_samples_that_wait_survive_a_restart_to_the_bit(policy: Policy) -> None:
    """Few samples of each batch are driven here, so that they wait from one to the next."""

    def ask(t: float) -> float:
        return 0.15 if t % 50.0 < 4.0 else 0.0

    settings = Settings(policy=policy)
    straight, resumed = start(settings), start(settings)
    waited = False
    for batch in batches(samples(ask, 400.0, seconds=900.0, seed=6)):
        straight, expected = step(settings, straight, batch)
        resumed, found = step(settings, State.from_dict(json.loads(json.dumps(resumed.to_dict()))), batch)
        waited |= straight.waiting.time.size > 0
        assert found.trained == expected.trained
        assert resumed.to_dict() == straight.to_dict() or not straight.model.is_trained
    assert waited
    assert straight.model.is_trained
