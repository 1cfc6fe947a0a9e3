"""M, C(ν), g(η) and J(η) against Fossen's formulas by hand, and Eq. 5 with them on a motion that is known."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.forecasting.over_recordings import free_run
from incsvr.numerics import Array
from incsvr.plant import Thruster, damping_moment, thruster_torque
from incsvr.plant.attitude import Restoring
from incsvr.plant.axes import AXES
from incsvr.plant.body import CORIOLIS, COUPLED_INERTIA, RESTORING, Coupled
from incsvr.plant.mass_and_coriolis import coriolis_force, coriolis_matrix, rigid_body_mass

CENTRE = (0.3, -0.02, 0.1)


def some_mass(random: np.random.Generator) -> Array:
    """M of a body with its centre of gravity off the origin and an added mass that couples everything."""
    root = random.normal(0.0, 3.0, (6, 6))
    return rigid_body_mass(40.0, np.diag([2.0, 9.0, 10.0]), CENTRE) + root @ root.T


def test_coriolis_does_no_work_and_is_skew() -> None:
    random = np.random.default_rng(900_200)
    mass, velocity = some_mass(random), random.normal(0.0, 1.0, (50, 6))
    force = coriolis_force(mass, velocity)
    np.testing.assert_allclose(np.sum(velocity * force, axis=1), 0.0, atol=1e-10)
    for each, taken in zip(velocity, force, strict=True):
        matrix = coriolis_matrix(mass, each)
        np.testing.assert_allclose(matrix, -matrix.T, atol=1e-12)
        np.testing.assert_allclose(matrix @ each, taken, atol=1e-10)


def test_three_degrees_of_freedom_are_fossens_by_hand() -> None:
    """Fossen 2011, Eq. 6.43 and 6.50: m = 50, x_g = 0.4, I_z = 12, X_u̇ = −5, Y_v̇ = −30, Y_ṙ = N_v̇ = −2, N_ṙ = −6."""
    m, x_g, u, v, r = 50.0, 0.4, 1.2, -0.3, 0.25
    added = np.zeros((6, 6))
    added[0, 0], added[1, 1], added[5, 5], added[1, 5], added[5, 1] = 5.0, 30.0, 6.0, 2.0, 2.0
    mass = rigid_body_mass(m, np.diag([1.0, 1.0, 12.0]), (x_g, 0.0, 0.0)) + added
    force = coriolis_force(mass, np.array([[u, v, 0.0, 0.0, 0.0, r]]))[0]
    rigid_body = [-m * (x_g * r + v) * r, m * u * r, m * (x_g * r + v) * u - m * u * v]
    hydrodynamic = [(-30.0 * v - 2.0 * r) * r, 5.0 * u * r, -(-30.0 * v - 2.0 * r) * u - 5.0 * u * v]
    by_hand = np.add(rigid_body, hydrodynamic)
    np.testing.assert_allclose(force[[0, 1, 5]], by_hand, rtol=1e-12)
    assert mass[1, 5] == m * x_g + 2.0


def test_weight_and_buoyancy_are_fossens_formula() -> None:
    w, b, (xg, yg, zg), (xb, yb, zb) = 400.0, 410.0, CENTRE, (0.02, 0.01, -0.2)
    roll, pitch = 0.4, -0.3
    s, c, st, ct = np.sin(roll), np.cos(roll), np.sin(pitch), np.cos(pitch)
    by_hand = [
        (w - b) * st,
        -(w - b) * ct * s,
        -(w - b) * ct * c,
        -(yg * w - yb * b) * ct * c + (zg * w - zb * b) * ct * s,
        (zg * w - zb * b) * st + (xg * w - xb * b) * ct * c,
        -(xg * w - xb * b) * ct * s - (yg * w - yb * b) * st,
    ]
    found = Restoring(w, b, CENTRE, (xb, yb, zb)).force(np.array([roll]), np.array([pitch]))
    np.testing.assert_allclose(found[0], by_hand, rtol=1e-12)


@pytest.mark.parametrize("axis", list(AXES))
def test_the_parts_of_equation_5_add_up_to_what_the_whole_body_takes(axis: str) -> None:
    random = np.random.default_rng(900_201)
    mass = some_mass(random)
    velocity, acceleration = random.normal(0.0, 1.0, (2, 20, 6))
    roll, pitch = random.normal(0.0, 0.3, (2, 20))
    weights = Restoring(400.0, 410.0, CENTRE, (0.0, 0.0, -0.2))
    own = list(AXES).index(axis)
    names = [each.rate for each in AXES.values()]
    others = tuple(name for k, name in enumerate(names) if k != own)
    coupled = Coupled(AXES[axis], mass, others, weights)
    motion = {name: (velocity[:, k], acceleration[:, k]) for k, name in enumerate(names)}
    parts = coupled.parts(velocity[:, own], motion, {"roll": roll, "pitch": pitch})
    assert set(parts) == {COUPLED_INERTIA, CORIOLIS, RESTORING}
    taken = mass[own, own] * acceleration[:, own] + np.sum(list(parts.values()), axis=0)
    whole = acceleration @ mass.T + weights.force(roll, pitch)
    whole += np.array([coriolis_matrix(mass, each) @ each for each in velocity])
    np.testing.assert_allclose(taken, whole[:, own], atol=1e-9)
    outside, slope = coupled.driving(motion, {"roll": roll, "pitch": pitch}, 20)
    np.testing.assert_allclose(outside + slope * velocity[:, own], np.sum(list(parts.values()), axis=0), atol=1e-9)


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
    rate = free_run(time, np.zeros(601), 0.2, inertia=2.0, damping=lambda r, _: 3.0 * r)
    np.testing.assert_allclose(rate, 0.2 * np.exp(-1.5 * time), rtol=1e-9)


def test_a_free_run_settles_where_the_damping_balances_the_torque() -> None:
    time = np.arange(0.0, 40.0, 0.5, dtype=np.float64)  # stamps coarser than the integration may be
    rate = free_run(
        time, np.full(time.size, 58.0), 0.0, inertia=350.0, damping=lambda r, _: 130.0 * r + 800.0 * r * abs(r)
    )
    assert abs(130.0 * rate[-1] + 800.0 * rate[-1] ** 2 - 58.0) < 1e-6


def test_a_free_run_that_runs_away_says_so() -> None:
    time = np.arange(0.0, 60.0, 0.1, dtype=np.float64)
    rate = free_run(time, np.ones(time.size), 0.1, inertia=1.0, damping=lambda r, _: -2.0 * r)
    assert np.isnan(rate[-1])
    assert np.isfinite(rate[:20]).all()
