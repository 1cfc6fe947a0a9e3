"""Free runs are compared on time: what lies between two samples speaks neither for nor against an effect."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.tracing.held_out import Errors
from incsvr.tracing.run import Array

TIME = np.asarray(0.05 * np.arange(4000), dtype=np.float64)
HALVES = (slice(0, 2000), slice(2000, 4000))
A_SAMPLE = 0.05


def coming(late: float, missed: Array) -> Errors:
    """Two pieces of a free run that comes so late [s] and beside that misses so much [rad/s], in blocks of a sample."""
    measured = 0.2 * np.sin(TIME) + 0.1 * np.sin(2.7 * TIME)
    simulated = 0.2 * np.sin(TIME - late) + 0.1 * np.sin(2.7 * (TIME - late)) + missed
    error, slope = simulated - measured, np.gradient(simulated, TIME)
    cut = {
        name: tuple(values[half] for half in HALVES)
        for name, values in (("time", TIME), ("measured", measured), ("simulated", simulated), ("error", error))
    }
    slopes, nothing_there = tuple(slope[half] for half in HALVES), tuple(np.zeros(2000) for _ in HALVES)
    return Errors(
        cut["time"], cut["measured"], cut["simulated"], cut["error"], slopes, cut["time"], cut["measured"],
        cut["error"], slopes, nothing_there, nothing_there,
    )  # fmt: skip


@pytest.mark.parametrize("late", [-0.02, 0.0, 0.02])
def test_what_a_free_run_comes_late_is_told_and_taken_off(late: float) -> None:
    """Pieces, samples and blocks alike; what it misses otherwise stays."""
    missed = 0.01 * np.cos(0.3 * TIME)
    errors = coming(late, missed)
    assert errors.late() == pytest.approx(late, abs=1e-3)
    on_time = errors.moved(errors.late(A_SAMPLE))
    for left in (on_time.free_run, on_time.block_error):
        np.testing.assert_allclose(np.concatenate(left), missed, atol=1e-3)


def test_what_is_longer_than_the_sampling_stays() -> None:
    errors = coming(0.08, np.zeros(TIME.size))
    assert errors.late(A_SAMPLE) == A_SAMPLE
    on_time, never = errors.moved(A_SAMPLE), coming(0.03, np.zeros(TIME.size))
    assert on_time.free_run_rmse() == pytest.approx(never.free_run_rmse(), rel=0.03)
