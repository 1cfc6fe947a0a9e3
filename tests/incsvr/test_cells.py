"""The forward form's cells and blocks: streams of any clock, without their spikes, and what of a torque acted."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from incsvr.tracing.forward.grid import cells, in_blocks
from incsvr.tracing.forward.interpolation import rate_without_spikes, torque_without_spikes
from incsvr.tracing.forward.scales import block_length
from incsvr.tracing.run import Run


def test_streams_of_unequal_rate_and_empty_cells_meet_on_one_grid() -> None:
    time = np.asarray(np.arange(0.0, 20.0, 0.01), dtype=np.float64)
    rate = np.where(np.arange(time.size) % 2 == 0, np.sin(time), np.nan)
    torque = np.where(np.arange(time.size) % 7 == 3, np.cos(time), np.nan)
    grid = in_blocks([Run("x", time, rate, torque)], 1.0, [], 0.1, measured=True)
    middle = grid.signals.time + 0.05
    np.testing.assert_allclose(grid.signals.rate[2:-2], np.sin(grid.signals.time[2:-2]), atol=2e-3)
    np.testing.assert_allclose((grid.signals.torque + grid.noise)[2:-2], np.cos(middle[2:-2]), atol=3e-3)


def test_a_pause_of_the_recorder_splits_a_run() -> None:
    time = np.concatenate([np.arange(0.0, 30.0, 0.05), np.arange(45.0, 80.0, 0.05)])
    grid = cells([Run("x", time, np.sin(time), np.cos(time))], 1.0, [])
    assert grid.starts.size == 3
    assert not np.any((grid.signals.time > 30.1) & (grid.signals.time < 44.9))


@pytest.mark.parametrize("offset", [0.0, 0.017])
def test_a_held_torque_and_the_motion_it_makes_agree_in_every_cell(offset: float) -> None:
    """I ṙ = τ, the gyro on a clock of its own: whatever the torque, nothing is left of a cell's equation."""
    period, inertia = 0.05, 2.0
    when = np.asarray(period * np.arange(400), dtype=np.float64)
    torque = np.random.default_rng(3).normal(size=400)
    total = np.concatenate([[0.0], np.cumsum(torque * period)])
    at = when[1:-1] + offset
    rate = (total[1:-2] + torque[1:-1] * offset) / inertia
    time = np.unique(np.concatenate([when, at]))
    turned, pushed = (
        np.where(np.isin(time, x), np.interp(time, x, y), np.nan) for x, y in ((at, rate), (when, torque))
    )
    grid = cells([Run("x", time, turned, pushed)], inertia, [])
    left = grid.signals.torque - inertia * grid.rise / grid.cell
    np.testing.assert_allclose(left, 0.0, atol=1e-9)


def test_spikes_go_and_steps_stay() -> None:
    steps = np.repeat([0.0, 40.0, -40.0], 50)
    noisy = steps + np.random.default_rng(1).normal(0.0, 1.0, steps.size)
    spiked = noisy.copy()
    spiked[[20, 75, 120]] += 30.0
    assert np.max(np.abs(torque_without_spikes(spiked) - steps)) < 6.0
    np.testing.assert_array_equal(torque_without_spikes(steps), steps)


def test_the_top_of_a_fast_turn_is_no_spike() -> None:
    time = np.asarray(np.arange(0.0, 60.0, 0.05), dtype=np.float64)
    turn = np.abs(np.sin(0.5 * time)) + np.random.default_rng(2).normal(0.0, 1e-3, time.size)
    spiked = turn.copy()
    spiked[[200, 700]] += 0.4
    clean = rate_without_spikes(spiked)
    assert np.max(np.abs(clean - turn)) < 0.02
    np.testing.assert_array_equal(np.flatnonzero(clean != spiked), [200, 700])


def test_blocks_follow_the_vehicle_and_not_the_levels_that_it_is_told_to_hold() -> None:
    """Levels of two minutes each: the vehicle follows each within two seconds, 1 % of outliers or not."""
    random = np.random.default_rng(0)
    time = np.asarray(np.arange(0.0, 1200.0, 0.05), dtype=np.float64)
    torque = np.repeat(random.uniform(-80.0, 80.0, 10), time.size // 10)
    rate = lfilter([0.05 / 300.0], [1.0, 0.05 / 2.0 - 1.0], torque)  # I = 300 kg m², 150 N m s/rad
    gyro = rate + random.normal(0.0, 1e-3, time.size)
    outliers = np.where(random.uniform(size=time.size) < 0.01, 400.0, torque)
    runs = [Run("levels", time, gyro, outliers, {})]
    assert block_length(runs, 300.0) == pytest.approx(0.8, rel=0.15)


@pytest.mark.parametrize("jumping", [True, False])
def test_the_torque_that_shapes_are_built_on_follows_the_command_and_holds_no_noise_of_its_own(jumping: bool) -> None:
    random = np.random.default_rng(5)
    time = np.asarray(np.arange(0.0, 600.0, 0.05), dtype=np.float64)
    levels = random.uniform(-60.0, 60.0, 120)[(time / 5.0).astype(int)]
    command = levels if jumping else 60.0 * np.sin(time / 3.0) + 30.0 * np.sin(time / 1.7)
    noise = random.normal(0.0, 6.0, time.size)
    grid = in_blocks([Run("x", time, np.sin(time), command + noise)], 1.0, [], 0.25, measured=True)
    blocks = in_blocks([Run("x", time, np.sin(time), command)], 1.0, [], 0.25, measured=False).signals.torque
    size = min(blocks.size, grid.noise.size)
    own = (grid.signals.torque + grid.noise)[:size] - blocks[:size]
    left = grid.signals.torque[:size] - blocks[:size]
    steady = np.abs(left) < 15.0  # a block in which the command jumps is told by itself
    assert np.mean(steady) > 0.97
    # neighbouring blocks share the sample between them
    assert abs(np.corrcoef(own[steady], left[steady])[0, 1]) < 0.2
    assert np.std(left[steady]) < np.std(own[steady])
