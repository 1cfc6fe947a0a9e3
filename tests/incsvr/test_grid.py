"""Streams of any clock on one grid, without their spikes, and the time scale of the motion."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from incsvr.tracing.run import Run
from incsvr.tracing.weak.grid import despiked, on_fine_grid, settling_time, time_scale
from incsvr.tracing.weak.posing import pose
from incsvr.tracing.weak.weak_form import split


def test_streams_of_unequal_rate_and_empty_cells_meet_on_one_grid() -> None:
    time = np.asarray(np.arange(0.0, 20.0, 0.01), dtype=np.float64)
    rate = np.where(np.arange(time.size) % 2 == 0, np.sin(time), np.nan)
    torque = np.where(np.arange(time.size) % 7 == 3, np.cos(time), np.nan)
    signals = on_fine_grid([Run("x", time, rate, torque)], 0.1, [], zero_order_hold=False, inertia=1.0)
    inside = slice(2, -2)
    np.testing.assert_allclose(signals.rate[inside], np.sin(signals.time[inside]), atol=2e-3)
    np.testing.assert_allclose(signals.torque[inside], np.cos(signals.time[inside]), atol=3e-3)


def test_a_pause_of_the_recorder_splits_a_run() -> None:
    time = np.concatenate([np.arange(0.0, 30.0, 0.05), np.arange(45.0, 80.0, 0.05)])
    signals = on_fine_grid([Run("x", time, np.sin(time), np.cos(time))], 0.1, [], zero_order_hold=False, inertia=1.0)
    assert len(signals.runs()) == 2
    assert not np.any((signals.time > 30.1) & (signals.time < 44.9))


def test_the_steps_in_which_a_torque_was_recorded_are_told() -> None:
    time = np.asarray(np.arange(0.0, 40.0, 0.05), dtype=np.float64)
    command = 10.0 * np.sin(time) + np.random.default_rng(4).normal(0.0, 1.0, time.size)
    for recorded, step in ((command, 0.0), (1.7 * np.round(command / 1.7), 1.7)):
        signals = on_fine_grid([Run("x", time, np.sin(time), recorded)], 0.1, [], zero_order_hold=False, inertia=1.0)
        assert signals.quantum == pytest.approx(step)


def test_spikes_go_and_steps_stay() -> None:
    steps = np.repeat([0.0, 40.0, -40.0], 50)
    noisy = steps + np.random.default_rng(1).normal(0.0, 1.0, steps.size)
    spiked = noisy.copy()
    spiked[[20, 75, 120]] += 30.0
    clean = despiked(spiked)
    assert np.max(np.abs(clean - steps)) < 6.0
    np.testing.assert_array_equal(despiked(steps), steps)


def test_what_drops_out_of_a_coarse_command_goes() -> None:
    """A command that mostly stays where it is deviates by nothing: one drop-out in a hundred is no usual deviation."""
    coarse = np.repeat([40.0, -40.0, 20.0, -20.0], 100) + 1.5 * (np.random.default_rng(3).random(400) < 0.1)
    dropped = coarse.copy()
    dropped[[20, 130, 250, 377]] = 0.0
    assert np.max(np.abs(despiked(dropped) - coarse)) <= 1.5


def test_a_command_that_runs_faster_than_it_scatters_is_no_spike() -> None:
    """Half of it hardly moves and half of it runs: there most samples are the median of their neighbourhood."""
    time = np.asarray(np.arange(0.0, 400.0, 0.05), dtype=np.float64)
    command = 5.0 * np.sin(2.0 * np.pi * time * np.where(time < 200.0, 0.01, 0.4))
    noisy = command + np.random.default_rng(2).normal(0.0, 0.2, time.size)
    assert np.mean(despiked(noisy) != noisy) < 0.001


def test_a_held_torque_and_the_motion_it_makes_agree_in_blocks_of_few_samples() -> None:
    """I ṙ = τ, sampled as fast as the torque is held: whatever the torque, nothing is left of a block's equation."""
    period, inertia = 0.05, 2.0
    time = np.asarray(period * np.arange(400), dtype=np.float64)
    torque = np.random.default_rng(3).normal(size=400)
    rate = np.concatenate([[0.0], np.cumsum(torque[:-1] * period / inertia)])
    signals = on_fine_grid([Run("x", time, rate, torque)], period, [], zero_order_hold=True, inertia=inertia)
    blocks = split(signals.start, 3, period)
    inside = slice(1, -1)
    left = blocks.mean(signals.torque) - inertia * blocks.slope(signals.ends)
    np.testing.assert_allclose(left[inside], 0.0, atol=1e-12)
    between_means = blocks.mean(signals.torque) - inertia * blocks.slope(signals.rate)
    assert np.std(between_means[inside]) > 0.05  # what the difference of cell means would leave


def test_a_corner_of_the_yaw_rate_between_its_stamps_is_not_cut_off() -> None:
    """I ṙ = τ under a torque that jumps, seen by a gyro with stamps of its own: nothing is left of a block's equation.

    Lines from stamp to stamp would leave six times as much.
    """
    inertia, period = 2.0, 0.05
    when = np.asarray(period * np.arange(4001), dtype=np.float64)
    torque = np.repeat(np.random.default_rng(4).uniform(-6.0, 6.0, 201), 20)[:4001]
    at = when[:-1] + 0.017
    total = np.concatenate([[0.0], np.cumsum(0.5 * period * (torque[1:] + torque[:-1]))])
    past = at - when[:-1]
    rate = (total[:-1] + past * (torque[:-1] + 0.5 * past * np.diff(torque) / period)) / inertia
    time = np.sort(np.concatenate([when, at]))
    turned, pushed = (
        np.where(np.isin(time, x), np.interp(time, x, y), np.nan) for x, y in ((at, rate), (when, torque))
    )
    signals = on_fine_grid([Run("x", time, turned, pushed)], period, [], zero_order_hold=False, inertia=inertia)
    blocks = split(signals.start, 6, period)
    left = blocks.mean(signals.torque) - inertia * blocks.slope(signals.ends)
    assert np.max(np.abs(left[1:-1])) < 0.02


def test_the_time_scale_is_that_of_the_motion() -> None:
    time = np.asarray(np.arange(0.0, 600.0, 0.05), dtype=np.float64)
    scale = time_scale([Run("x", time, np.sin(2 * np.pi * time / 60.0), np.zeros(time.size))])
    assert scale == pytest.approx(10.0, rel=0.03)  # cos = 1/2 after a sixth of the period


def test_what_stays_longer_than_the_vehicle_settles_is_not_its_time_scale() -> None:
    """Levels of two minutes each: the vehicle follows each within seconds, 1 % of outliers or not."""
    random = np.random.default_rng(0)
    time = np.asarray(np.arange(0.0, 1200.0, 0.05), dtype=np.float64)
    torque = np.repeat(random.uniform(-80.0, 80.0, 10), time.size // 10)
    rate = lfilter([0.05 / 300.0], [1.0, 0.05 / 2.0 - 1.0], torque)  # I = 300 kg m², 150 N m s/rad
    gyro = rate + random.normal(0.0, 1e-3, time.size)
    outliers = np.where(random.uniform(size=time.size) < 0.01, 400.0, torque)
    runs = [Run("levels", time, gyro, outliers, {})]
    assert settling_time(runs, 300.0) == pytest.approx(2.0, rel=0.1)
    assert time_scale(runs) > 30.0
    assert pose(runs, 300.0, []).signals.scale == pytest.approx(16.0, rel=0.1)
