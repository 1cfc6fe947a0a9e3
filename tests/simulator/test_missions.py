"""Ordinary missions: the vehicle does what they say, and its controller answers the water and the logged gyro."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simulator.missions import GYRO_NOISE, VEHICLES, Mission, Outcome, play
from simulator.trial_effects.physics import Array
from simulator.trial_vehicle import STEP

SHORT = 300.0


def held(outcome: Outcome) -> Array:
    """(n,) the command at every integration step [N m]."""
    command = outcome.motion.command
    return np.repeat(command, outcome.motion.time.size // command.size)


@pytest.mark.parametrize("vehicle", sorted(VEHICLES))
def test_a_survey_turns_by_half_a_turn_and_holds_its_legs(vehicle: str) -> None:
    outcome = play(Mission("survey", vehicle, seed=1, duration=600.0))
    heading = outcome.motion.heading
    assert np.ptp(heading) == pytest.approx(math.pi, abs=0.9)
    on_a_leg = np.minimum(np.abs(heading), np.abs(np.abs(heading) - math.pi)) < 0.25
    assert 0.8 < np.mean(on_a_leg) < 0.99
    assert np.abs(outcome.driven_rates).max() > 0.6 * VEHICLES[vehicle].scale.rate


@pytest.mark.slow
@pytest.mark.parametrize("vehicle", sorted(VEHICLES))
def test_a_held_station_hardly_moves(vehicle: str) -> None:
    outcome = play(Mission("station", vehicle, seed=1))
    assert 0.004 < np.std(outcome.motion.yaw_rate) < 0.02
    assert np.mean(outcome.motion.command == 0.0) > 0.5
    assert np.abs(outcome.motion.heading).max() < 0.3
    assert outcome.driven_rates.size == 0


def test_on_deck_the_vehicle_is_carried_and_its_thrusters_rest() -> None:
    outcome = play(Mission("on_deck", "auv", seed=1, duration=SHORT))
    assert np.std(outcome.motion.yaw_rate) > 5 * GYRO_NOISE
    assert not outcome.recording.columns["torque"].any()
    assert outcome.driven_rates.size == 0


@pytest.mark.slow
def test_a_badly_tuned_heading_control_goes_on_swinging() -> None:
    late = play(Mission("wagging", "auv", seed=1, water=0.0)).motion.yaw_rate[-round(60.0 / STEP) :]
    assert np.count_nonzero(np.diff(np.sign(late))) >= 4
    assert np.abs(late).max() > 0.05


def test_torque_to_one_side_never_changes_its_side() -> None:
    for seed in range(3):
        torque = play(Mission("one_sided", "auv", seed, duration=SHORT)).recording.columns["torque"]
        assert np.all(torque > 0.0) or np.all(torque < 0.0)


@pytest.mark.parametrize("vehicle", sorted(VEHICLES))
@pytest.mark.parametrize("kind", ["survey", "rate_control", "bursts"])
def test_in_still_water_the_declared_model_explains_the_log(kind: str, vehicle: str) -> None:
    outcome = play(Mission(kind, vehicle, seed=1, water=0.0, duration=SHORT))
    drag, inertia = VEHICLES[vehicle].drag, outcome.inertia
    rate, rates, fine = 0.0, [], 40
    for torque in outcome.recording.columns["torque"].tolist():
        rates.append(rate)
        for _ in range(fine):
            rate += 0.1 / fine * (torque - drag(rate)) / inertia
    error = outcome.recording.columns["yaw_rate"] - rates
    assert np.sqrt(np.mean(error**2)) < 2.0 * GYRO_NOISE


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["transit", "rate_control"])
def test_the_controller_hears_the_logged_gyro_and_no_other(kind: str) -> None:
    def heard(separate: bool) -> float:
        """How strongly the command answers the logged gyro's noise."""
        outcome = play(Mission(kind, "auv", seed=1, separate_gyro=separate, water=0.0))
        time, yaw_rate = outcome.recording.streams()["yaw_rate"]
        noise = yaw_rate - np.interp(time, outcome.motion.time, outcome.motion.yaw_rate)
        assert np.std(noise) == pytest.approx(GYRO_NOISE, rel=0.05)
        # The changes from beat to beat, so that what lasts does not hide the noise, without those of another set point.
        change = np.diff(outcome.motion.command[: noise.size])
        usual = np.abs(change) < 5.0 * np.median(np.abs(change))
        return float(np.corrcoef(np.diff(noise)[usual], change[usual])[0, 1])

    assert heard(separate=False) < -0.5
    assert abs(heard(separate=True)) < 0.05


@pytest.mark.slow
def test_the_torque_of_a_survey_answers_the_water() -> None:
    rough, still = (play(Mission("transit", "auv", seed=1, water=water)).motion.command for water in (1.0, 0.0))
    assert np.std(rough) > 1.2 * np.std(still)


def test_a_controller_at_its_own_rate_is_logged_at_its_own_rate() -> None:
    for control_rate in (5.0, 8.0, 20.0):
        recording = play(Mission("survey", "rov", seed=1, control_rate=control_rate, duration=60.0)).recording
        np.testing.assert_allclose(np.diff(recording.time), 1.0 / control_rate)
    slow = play(Mission("survey", "rov", 1, control_rate=4.0, separate_gyro=True, gyro_rate=20.0, duration=60.0))
    streams = slow.recording.streams()
    np.testing.assert_allclose(np.diff(streams["yaw_rate"][0]), 0.05, atol=2e-6)
    np.testing.assert_allclose(np.diff(streams["torque"][0]), 0.25)
    with pytest.raises(ValueError, match="whole number of steps"):
        play(Mission("survey", "rov", seed=1, control_rate=7.0))


def test_other_effects_are_those_of_the_trials() -> None:
    outcome = play(Mission("survey", "auv", seed=1, effect="coulomb", duration=SHORT))
    assert set(outcome.truth) == {"moment_nm"}
    with pytest.raises(KeyError):
        play(Mission("survey", "auv", seed=1, effect="gremlins", duration=SHORT))
