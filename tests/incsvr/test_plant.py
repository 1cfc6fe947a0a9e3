"""The plant against what can be worked out by hand."""

from __future__ import annotations

import numpy as np

from incsvr.free_run.integrator import free_run
from incsvr.plant import Thruster, damping_moment, thruster_torque


def test_thruster_moments_follow_the_papers_formula() -> None:
    bow, stern = Thruster(lever=1.2, thrust=2e-3, inflow=-5e-3), Thruster(lever=-1.0, thrust=3e-3, inflow=-4e-3)
    rotor = (np.array([100.0, -50.0, 0.0]), np.array([-80.0, 80.0, 20.0]))
    water = (np.array([0.2, 0.1, 0.3]), np.array([-0.1, 0.0, 0.2]))
    by_hand = [
        1.2 * (2e-3 * 100 * 100 - 5e-3 * 0.2 * 100) - 1.0 * (-3e-3 * 80 * 80 - 4e-3 * -0.1 * 80),
        1.2 * (-2e-3 * 50 * 50 - 5e-3 * 0.1 * 50) - 1.0 * (3e-3 * 80 * 80),
        -1.0 * (3e-3 * 20 * 20 - 4e-3 * 0.2 * 20),
    ]
    np.testing.assert_allclose(thruster_torque((bow, stern), rotor, water), by_hand, rtol=1e-12)


def test_damping_moment_is_equation_5() -> None:
    np.testing.assert_array_equal(damping_moment(np.array([10.0, -3.0]), np.array([0.02, 0.01]), 350.0), [3.0, -6.5])


def test_a_free_run_with_linear_damping_decays_exponentially() -> None:
    time = np.linspace(0.0, 3.0, 601, dtype=np.float64)
    rate = free_run(time, np.zeros(601), 0.2, inertia=2.0, damping=lambda r: 3.0 * r)
    np.testing.assert_allclose(rate, 0.2 * np.exp(-1.5 * time), rtol=1e-9)


def test_a_free_run_settles_where_the_damping_balances_the_torque() -> None:
    time = np.arange(0.0, 40.0, 0.5, dtype=np.float64)  # stamps coarser than the integration may be
    rate = free_run(
        time, np.full(time.size, 58.0), 0.0, inertia=350.0, damping=lambda r: 130.0 * r + 800.0 * r * abs(r)
    )
    assert abs(130.0 * rate[-1] + 800.0 * rate[-1] ** 2 - 58.0) < 1e-6


def test_a_free_run_that_runs_away_says_so() -> None:
    time = np.arange(0.0, 60.0, 0.1, dtype=np.float64)
    rate = free_run(time, np.ones(time.size), 0.1, inertia=1.0, damping=lambda r: -2.0 * r)
    assert np.isnan(rate[-1])
    assert np.isfinite(rate[:20]).all()
