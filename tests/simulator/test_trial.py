"""The trial vehicle is a vehicle: its drag, its energy, its commands (its effects: test_worlds.py)."""

from __future__ import annotations

import numpy as np
import pytest

from simulator.trial import Trial, play
from simulator.trial_command import EXCITATIONS, Command
from simulator.trial_effects import Physics
from simulator.trial_effects.physics import Array
from simulator.trial_vehicle import DRAGS, SCALES, STEP, Motion, drag, move

LENG = SCALES["leng"]


def drive(physics: Physics, table: float | Array, seconds: float = 60.0) -> Motion:
    """The noiseless vehicle under a constant or tabled command."""
    steps = round(seconds / STEP)
    values = np.broadcast_to(table, 2 * steps + 1).tolist()
    return move(physics, Command(values), np.zeros(steps), 0.0)


@pytest.mark.parametrize("shape", sorted(DRAGS))
@pytest.mark.parametrize("vehicle", sorted(SCALES))
def test_drag_takes_energy_and_vanishes_at_rest(shape: str, vehicle: str) -> None:
    scale = SCALES[vehicle]
    curve = drag(shape, scale)
    rates = np.linspace(-1.2, 1.2, 241) * scale.rate
    moments = np.array([curve(rate) for rate in rates.tolist()])
    assert curve(0.0) == 0.0
    assert np.all(moments * rates >= 0.0)
    assert np.all(np.diff(moments) > 0.0)
    assert 0.6 * scale.torque < curve(scale.rate) < 1.1 * scale.torque


def test_no_drag_is_a_polynomial_of_the_rate_and_its_square() -> None:
    rates = np.linspace(-1.0, 1.0, 201)
    for curve in DRAGS.values():
        moments = np.array([curve(rate) for rate in rates.tolist()])
        terms = np.column_stack([rates, rates * np.abs(rates)])
        left = moments - terms @ np.linalg.lstsq(terms, moments, rcond=None)[0]
        assert np.std(left) > 0.004 * np.std(moments)


def test_without_drag_the_work_of_the_thrusters_is_the_energy_of_the_turning() -> None:
    random = np.random.default_rng(0)
    command = 30.0 * np.cumsum(random.standard_normal(2 * round(60 / STEP) + 1)) * 0.02
    motion = drive(Physics(LENG.inertia, lambda _rate: 0.0), command)
    work = np.sum(0.5 * (motion.command[1:] + motion.command[:-1]) * np.diff(motion.heading))
    energy = 0.5 * LENG.inertia * motion.yaw_rate[-1] ** 2
    assert work == pytest.approx(energy, rel=1e-3)


def test_the_integrator_follows_the_exact_solution_to_fourth_order() -> None:
    motion = drive(Physics(LENG.inertia, lambda rate: 300.0 * rate), 60.0)
    exact = 0.2 * -np.expm1(-300.0 / LENG.inertia * motion.time)
    np.testing.assert_allclose(motion.yaw_rate, exact, atol=1e-9)


@pytest.mark.parametrize("excitation", EXCITATIONS)
def test_every_excitation_turns_the_vehicle_and_stays_within_the_thrusters(excitation: str) -> None:
    for vehicle, scale in SCALES.items():
        motion = play(Trial(seed=4, vehicle=vehicle, excitation=excitation, duration=150.0)).motion
        assert np.max(np.abs(motion.command)) <= scale.torque * (1 + 1e-12)
        assert np.std(motion.yaw_rate) > 0.2 * scale.rate
        assert np.max(np.abs(motion.yaw_rate)) < 1.5 * scale.rate


def test_with_nothing_hidden_nothing_is_lacking() -> None:
    quiet = play(Trial(seed=3, autocorrelation=0.9, duration=60.0))
    np.testing.assert_allclose(quiet.lacking, 0.0, atol=1e-9 * LENG.torque)
    assert quiet.evidence < 1e-9
    assert quiet.truth == {}


def test_a_second_effect_leaves_the_first_as_it_was() -> None:
    alone = play(Trial(seed=5, effects=("coulomb",), duration=30.0))
    for names in (("coulomb", "wave"), ("wave", "coulomb")):
        both = play(Trial(seed=5, effects=names, duration=30.0))
        assert alone.truth["coulomb"] == both.truth["coulomb"]


def test_names_that_do_not_exist_are_refused() -> None:
    with pytest.raises(KeyError, match="magic"):
        play(Trial(seed=0, effects=("magic",), duration=10.0))
    with pytest.raises(KeyError, match="spoon"):
        play(Trial(seed=0, effects=("coupling:spoon",), duration=10.0))
    with pytest.raises(KeyError, match="wiggle"):
        play(Trial(seed=0, excitation="wiggle", duration=10.0))
