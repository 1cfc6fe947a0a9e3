"""The integrator against others: SciPy's, and the plant's Coriolis force."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from incsvr.model.identification import structure_of
from incsvr.model.rows import Factor, damping, memory, row, value
from incsvr.model.simulation import predict, simulate
from incsvr.model.structure import Structure
from incsvr.model.tangent import tangent
from incsvr.model.windows import cut
from incsvr.numerics import Array, Streams
from incsvr.plant.axes import AXES, VELOCITIES
from incsvr.plant.mass_and_coriolis import coriolis_force
from tests.incsvr.model.turning import Turning, dive

MASS = np.array([[76.0, 0.0, 0.0], [0.0, 147.0, 8.0], [0.0, 8.0, 41.0]])
LINEAR, QUADRATIC = np.array([20.0, 60.0, 12.0]), np.array([40.0, 90.0, 30.0])
MEMORY, CONSTANT = 15.0, 1.7
"""Drag by the yaw rate that was [N m s], and how it follows [s]."""
HOLDS, SECONDS = 1.0, 20.0
"""Each effort holds so long, over so long [s]."""


def efforts() -> Array:
    """(20, 3) of surge, sway and yaw [N], [N m]."""
    return np.random.default_rng(8).uniform(-1.0, 1.0, (round(SECONDS / HOLDS), 3)) * [80.0, 90.0, 25.0]


def by_scipy(start: Array, instants: Array) -> Array:
    """(n, 3) surge, sway, yaw rate; Fossen 2011, Eq. 6.53 by hand."""

    def slope(_: float, state: Array, tau: Array) -> Array:
        u, v, r, follows = state
        across = MASS[1, 1] * v + MASS[1, 2] * r
        coriolis = np.array([-across * r, MASS[0, 0] * u * r, across * u - MASS[0, 0] * u * v])
        drag = (LINEAR + QUADRATIC * np.abs(state[:3])) * state[:3] + np.array([0.0, 0.0, MEMORY * follows])
        return np.append(np.linalg.solve(MASS, tau - coriolis - drag), (r - follows) / CONSTANT)

    state, found = np.append(start, start[2]), [start]
    for k, tau in enumerate(efforts()):
        inside = instants[(instants > k * HOLDS + 1e-9) & (instants <= (k + 1) * HOLDS + 1e-9)]
        solved = solve_ivp(
            slope, (k * HOLDS, inside[-1]), state, t_eval=inside, args=(tau,), rtol=1e-10, atol=1e-12, method="DOP853"
        )
        found.extend(solved.y[:3].T)
        state = solved.y[:, -1]
    return np.array(found)


def test_three_axes_with_coriolis_coupled_inertia_and_memory_move_as_scipy_has_it() -> None:
    axes = ("surge", "sway", "yaw_rate")
    structure = Structure(
        axes,
        axes,
        (*(row for axis in axes for row in damping(axis)), memory("yaw_rate", (1.0,))),
        tied=True,
        coupled=(("sway", "yaw_rate"),),
        ways=dict.fromkeys(axes, "hold"),
    )
    theta = {"mass:sway*yaw_rate": MASS[1, 2], "memory@yaw_rate": MEMORY, "time:memory@yaw_rate": np.log(CONSTANT)}
    for i, axis in enumerate(axes):
        theta |= {f"mass:{axis}": np.log(MASS[i, i]), f"linear@{axis}": LINEAR[i], f"quadratic@{axis}": QUADRATIC[i]}
    start = np.array([0.5, -0.2, 0.3])
    ends = np.array([0.0, SECONDS])
    series: dict[str, tuple[Array, Array]] = {axis: (ends, np.full(2, start[i])) for i, axis in enumerate(axes)}
    stamps = np.append(np.arange(0.0, SECONDS, HOLDS), SECONDS)
    for axis, effort in zip(("surge", "sway", "yaw"), np.vstack([efforts(), efforts()[-1]]).T, strict=True):
        series[AXES[axis].effort] = (stamps, effort)
    windows = cut([series], structure, 0.05, np.inf)
    point = np.array([theta[name] for name in structure.names])
    course = simulate(structure, point, windows, windows.starts).states[:, :3, 0]
    expected = by_scipy(start, np.asarray(0.05 * np.arange(course.shape[0])))
    assert np.ptp(expected, axis=0).min() > 0.5
    assert np.abs(course - expected).max() < 1e-4 * np.abs(expected).max()


def test_the_coriolis_force_of_a_tied_structure_is_the_plants() -> None:
    """Without effort and drag M ν̇ = −C(ν) ν at each of many velocities, for a full M."""
    random = np.random.default_rng(3)
    root = random.normal(size=(6, 6))
    mass = root @ root.T + 6.0 * np.eye(6)
    pairs = tuple((a, b) for i, a in enumerate(VELOCITIES) for b in VELOCITIES[i + 1 :])
    structure = Structure(VELOCITIES, (), tied=True, coupled=pairs)
    place = {axis: i for i, axis in enumerate(VELOCITIES)}
    theta = {f"mass:{axis}": np.log(mass[i, i]) for axis, i in place.items()}
    theta |= {f"mass:{a}*{b}": mass[place[a], place[b]] for a, b in pairs}
    stamps = np.asarray(0.1 * np.arange(31))
    velocity = random.normal(size=(31, 6))
    series: Streams = {axis: (stamps, velocity[:, i]) for axis, i in place.items()}
    windows = cut([series], structure, 0.1, 0.1)
    point = np.array([theta[name] for name in structure.names])
    slopes = simulate(structure, point, windows, windows.starts).slopes[0]
    expected = coriolis_force(mass, windows.starts.T)
    assert windows.starts.shape == (6, 30)
    assert np.abs(mass @ slopes + expected.T).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize("predictor", [False, True])
def test_the_tangent_is_the_slope_of_the_predictions(predictor: bool) -> None:
    """Against differences, for masses, C(ν), rows of each kind, a memory, stages of the effort, gains and starts."""
    log = dict(dive(Turning(inertia=12.0), 1, seconds=30.0))
    log["pitch"] = (log["surge"][0], 0.2 * np.sin(log["surge"][0]))
    log["roll"] = log["pitch"]
    log["sway"], log["surge_force"] = (log["surge"][0] + 0.03, 0.3 * log["surge"][1]), log["torque"]
    axes = ("surge", "sway", "yaw_rate")
    kinds = ("size", "square", "root", "sine", "cosine", "drag", "sine2", "cosine2", "down_x", "down_y", "down_z")
    rows = [row(kind, "yaw_rate", Factor(kind, "surge"), Factor("sign", "yaw_rate", 0.1)) for kind in kinds]
    rows += [row("inflow", "surge", value("surge"), Factor("root", "torque")), memory("yaw_rate", (1.0,))]
    structure = Structure(
        axes,
        ("surge", "yaw_rate"),
        (*(each for axis in axes for each in damping(axis)), *rows),
        tied=True,
        coupled=(("sway", "yaw_rate"),),
        stages=(("lag", "yaw_rate"), ("exponent", "surge")),
        shift_priors={"yaw_rate": 0.05},
        predictor=predictor,
        channels=("roll", "pitch"),
    )
    windows = cut([log], structure, 0.05, 5.0)
    theta = dict.fromkeys(structure.names, 0.3) | {"mass:surge": 3.0, "mass:sway": 3.5, "mass:yaw_rate": 2.5}
    point, units = np.array([theta[name] for name in structure.names]), np.full(len(structure.names), 0.1)
    found = tangent(simulate(structure, point, windows, windows.starts), point, units)
    nudges = 1e-4 * np.diag(np.r_[units, np.ones(3)])
    ends = [
        predict(
            structure,
            point[:, None] + sign * nudges[: point.size],
            windows,
            windows.starts[:, None] + sign * nudges[point.size :, :, None],
        )
        for sign in (1.0, -1.0)
    ]
    expected = (ends[0] - ends[1]) / 2e-4
    size = np.sqrt(np.mean(expected**2, axis=0))
    assert size.min() > 0.0
    assert np.sqrt(np.mean((found - expected) ** 2, axis=0) / size**2).max() < 0.01


def test_columns_of_any_layout_are_predicted_alike() -> None:
    run = dive(Turning(), 1)
    structure = structure_of([run], ["yaw_rate"])
    windows = cut([run], structure, 0.05, 5.0)
    columns = np.repeat(np.array([[np.log(12.0)], [5.0], [9.0], [0.0]]), 3, axis=1)
    starts = np.repeat(windows.starts[:, None], 3, axis=1)
    turned = np.asfortranarray(starts)
    assert np.array_equal(predict(structure, columns, windows, starts), predict(structure, columns, windows, turned))
