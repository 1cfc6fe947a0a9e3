"""What a trial vehicle's recorder keeps: noise of the colour and size that were asked for, clocks, outliers."""

from __future__ import annotations

import numpy as np
import pytest

from simulator.trial import NOISE, Trial, play
from simulator.trial_command import Command
from simulator.trial_effects import Physics
from simulator.trial_sensors import PERIOD, Noise
from simulator.trial_vehicle import SCALES, STEP, Gyro, move

LENG = SCALES["leng"]


@pytest.mark.parametrize("autocorrelation", [0.0, 0.5, 0.9, 0.98])
def test_the_noise_has_the_autocorrelation_and_the_size_that_were_asked_for(autocorrelation: float) -> None:
    random = np.random.default_rng(2)
    for _ in range(3):
        noise = Noise.drawn(3.5, autocorrelation, random)
        total = noise.water(200_000, random) + noise.sensor * random.standard_normal(200_000)
        assert np.corrcoef(total[1:], total[:-1])[0, 1] == pytest.approx(autocorrelation, abs=0.01)
        assert np.std(total) == pytest.approx(3.5, rel=0.06)


def test_the_residual_of_the_true_model_is_the_noise_that_was_asked_for() -> None:
    quiet = play(Trial(seed=7, autocorrelation=0.5, excitation="multisine"))
    motion = quiet.motion
    moment = LENG.torque * NOISE
    water = quiet.inertia * motion.acceleration - motion.command
    curve = np.polynomial.Polynomial.fit(motion.yaw_rate, water, 15)
    left = water - curve(motion.yaw_rate)
    assert 0.6 * moment < np.std(left) < 1.05 * moment


@pytest.mark.slow
def test_noise_in_the_torque_alone_colours_the_recording_and_leaves_the_vehicle_in_peace() -> None:
    coloured, white = (
        play(Trial(seed=7, autocorrelation=rho, noise="torque", excitation="steps")) for rho in (0.9, 0.0)
    )
    np.testing.assert_array_equal(coloured.motion.yaw_rate, white.motion.yaw_rate)
    time, torque = coloured.recording.time, coloured.recording.columns["torque"]
    here = np.isfinite(torque)
    noise = torque[here] - np.interp(time[here], coloured.motion.time, coloured.motion.command)
    usual = np.abs(noise) < 12.0  # no outlier
    pairs = usual[1:] & usual[:-1]
    again = float(np.corrcoef(noise[1:][pairs], noise[:-1][pairs])[0, 1])
    assert again == pytest.approx(0.9 ** (float(np.median(np.diff(time[here]))) / PERIOD), abs=0.05)
    assert noise[usual].std() == pytest.approx(NOISE * LENG.torque, rel=0.2)


def test_a_commanded_torque_is_what_was_asked_and_stands_until_the_next() -> None:
    for seed in range(4):
        outcome = play(Trial(seed=seed, excitation="multisine", duration=60.0, noise="commanded"))
        here = np.isfinite(outcome.recording.columns["torque"])
        time, torque = outcome.recording.time[here], outcome.recording.columns["torque"][here]
        motion = outcome.motion
        standing = np.searchsorted(time, motion.time + 0.2 * float(np.median(np.diff(time))), side="right") - 1
        np.testing.assert_allclose(torque[np.maximum(standing, 0)], motion.command, atol=1e-9)


def test_a_controller_sees_what_the_gyro_logs_and_its_command_stands() -> None:
    steps = round(20.0 / STEP)
    error = np.zeros(400)
    error[100] = 0.1
    gyro = Gyro(np.linspace(0.0, 19.95, 400), error, step=0.03)
    held = Command([0.0] * (2 * steps + 1), proportional=200.0, limit=100.0, hold=4)
    motion = move(Physics(LENG.inertia, lambda _: 0.0), held, np.zeros(steps), 0.0, gyro=gyro)
    asked = motion.command[np.searchsorted(motion.time, [4.95, 5.0, 5.05, 5.1, 5.2])]
    np.testing.assert_allclose(asked[:3], [0.0, -18.0, -18.0])  # of 0.1 rad/s the gyro shows three steps
    assert gyro.seen(motion)[100] == pytest.approx(0.09)
    assert abs(asked[3]) < 6.1  # the vehicle turns by now, a step of the gyro or none


def test_streams_on_their_own_clocks_leave_empty_cells_and_one_clock_leaves_none() -> None:
    trials = [play(Trial(seed=seed, duration=30.0)) for seed in range(8)]
    apart = [trial for trial in trials if np.isnan(trial.recording.columns["yaw_rate"]).any()]
    together = [trial for trial in trials if not np.isnan(trial.recording.columns["yaw_rate"]).any()]
    assert apart
    assert together
    for trial in trials:
        assert np.all(np.diff(trial.recording.time) > 0)
        for column in trial.recording.columns.values():
            assert np.isfinite(column).sum() > 20
    for trial in together:
        np.testing.assert_allclose(np.diff(trial.recording.time), PERIOD)


@pytest.mark.slow
def test_one_torque_in_a_hundred_is_an_outlier() -> None:
    for seed in range(4):
        outcome = play(Trial(seed=seed, excitation="sine"))
        known = ~np.isnan(outcome.recording.columns["torque"])
        true = np.interp(outcome.recording.time[known], outcome.motion.time, outcome.motion.command)
        off = np.abs(outcome.recording.columns["torque"][known] - true)
        assert 0.004 < np.mean(off > 4.9 * NOISE * LENG.torque) < 0.02
