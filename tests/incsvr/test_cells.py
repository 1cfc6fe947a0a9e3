"""The forward form's cells: streams of any clock, without their spikes."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.tracing.forward.grid import cells
from incsvr.tracing.forward.interpolation import without_spikes
from incsvr.tracing.run import Run


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


def test_the_top_of_a_fast_turn_is_no_spike() -> None:
    time = np.asarray(np.arange(0.0, 60.0, 0.05), dtype=np.float64)
    turn = np.abs(np.sin(0.5 * time)) + np.random.default_rng(2).normal(0.0, 1e-3, time.size)
    spiked = turn.copy()
    spiked[[200, 700]] += 0.4
    clean = without_spikes(spiked)
    assert np.max(np.abs(clean - turn)) < 0.02
    np.testing.assert_array_equal(np.flatnonzero(clean != spiked), [200, 700])
