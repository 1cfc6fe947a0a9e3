"""Intervals of a vehicle's parameters, and what keeps inertias unbiased."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.numerics import Array
from incsvr.vehicle import on_grid
from incsvr.vehicle.fitting import Fit, student_weight
from incsvr.vehicle.intervals import Scatter, intervals
from incsvr.vehicle.structure import Structure

STRUCTURE = Structure((), (), (), (), np.zeros((6, 6)))


def fitted(slope: Array, measured: Array) -> Fit:
    """The fit of one parameter to numbers (windows,) that are the slope times it, under Student's t."""
    parameter, variance = 0.0, np.ones(1)
    for _ in range(60):
        error = (slope * parameter - measured)[:, None, None]
        weight = student_weight(error, variance)
        parameter -= float(np.sum(slope * error[:, 0, 0] * weight[:, 0]) / np.sum(slope**2 * weight[:, 0]))
    error = (slope * parameter - measured)[:, None, None]
    return Fit(
        STRUCTURE, np.array([parameter]), np.ones(1), variance, error, slope[None, :, None, None],
        student_weight(error, variance),
    )  # fmt: skip


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    rng, repeats, held = np.random.default_rng(611), 600, 0
    free = (np.array([-np.inf]), np.array([np.inf]))
    for _ in range(repeats):
        slope = rng.standard_normal(120)
        low, high = intervals(fitted(slope, 0.7 * slope + rng.standard_normal(120)), free)
        held += bool(low[0] <= 0.7 <= high[0])
    assert 0.925 < held / repeats < 0.98


def test_a_parameter_that_rests_on_a_few_blocks_has_few_degrees_of_freedom() -> None:
    rng, along = np.random.default_rng(612), np.eye(1)
    even, rare = rng.standard_normal(240), 0.01 * rng.standard_normal(240)
    rare[100:120] = 1.0
    freedom = [
        float(Scatter.of(fitted(slope, slope + rng.standard_normal(240))).freedom(along)[0]) for slope in (even, rare)
    ]
    assert freedom[0] > 15.0
    assert freedom[1] < 4.0


@pytest.mark.parametrize("at", [0.25, 0.5, 0.75])
def test_a_step_within_a_cell_keeps_its_mean_and_first_moment(at: float) -> None:
    time: Array = np.arange(160) * np.float64(0.25)
    force: Array = 6.0 * np.asarray(time >= 20.0 + at, dtype=np.float64)
    motion = on_grid([{"surge": (time, np.asarray(np.sin(time), dtype=np.float64)), "surge_force": (time, force)}], 1.0)
    mean, rise = motion.effort[20, 0], motion.effort_rise[20, 0]
    assert mean == pytest.approx(6.0 * (1.0 - at))
    # The first moment about the middle of the cell of a line is its rise / 12, that of the step 6 at (1 − at) / 2.
    assert rise / 12.0 == pytest.approx(6.0 * at * (1.0 - at) / 2.0, rel=0.05)
    assert np.count_nonzero(motion.effort_rise) == 1
