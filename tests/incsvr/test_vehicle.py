"""A whole vehicle, identified from simulated dives: parameters, errors, and what is said where data do not suffice."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.numerics import Streams
from incsvr.plant.terms import extras, own_damping, restoring
from incsvr.vehicle import Identified, Vehicle, identify, on_grid
from incsvr.vehicle.fitting import Windows, slopes
from incsvr.vehicle.sensitivities import sensitivities
from incsvr.vehicle.simulation import simulate
from incsvr.vehicle.structure import Structure, lagged
from simulator.vehicles import BODIES
from simulator.vehicles import Vehicle as Body
from tests.worlds import swim


def dive(kind: str, seconds: float, seed: int) -> tuple[Body, Streams]:
    """A body drawn by the seed, and the log of a dive of it."""
    body = BODIES[kind](np.random.default_rng(seed))
    return body, swim(body, seconds, seed)


@cache
def torpedo() -> tuple[Body, Identified]:
    """A torpedo in the plane, identified from four minutes and judged on one."""
    body = BODIES["torpedo"](np.random.default_rng(41))
    motion = on_grid([swim(body, 240.0, 41)])
    return body, identify(motion, on_grid([swim(body, 60.0, 42)], motion.step), name="torpedo")


def test_inertias_and_drag_are_near_the_truth() -> None:
    body, found = torpedo()
    for k, axis in ((0, "surge"), (1, "sway"), (5, "yaw")):
        assert found.vehicle.mass[axis, axis].value == pytest.approx(body.mass[k, k], rel=0.1)
        speed = 0.7 * float(found.vehicle.fastest[k])
        terms = {term.name: p.value for term, p in found.vehicle.terms.items() if term.axis == axis}
        drag = terms["linear"] * speed + terms["quadratic"] * speed**2
        assert drag == pytest.approx(body.linear[k] * speed + body.quadratic[k] * speed**2, rel=0.15)


def test_unseen_dives_are_predicted_with_all_axes_at_once() -> None:
    _, found = torpedo()
    model, hold, _ = found.errors.horizons[5.0]
    assert np.all(model < 0.25 * hold)
    assert np.all(found.errors.free_run < 0.3 * found.errors.zero)
    assert found.errors.track[5.0] < 0.5
    assert set(found.refusals) == {"heave", "roll", "pitch"}


def test_a_vehicle_is_the_same_after_plain_data() -> None:
    _, found = torpedo()
    again = Vehicle.from_dict(found.vehicle.to_dict())
    assert again.to_dict() == found.vehicle.to_dict()
    assert np.array_equal(again.mass_matrix, found.vehicle.mass_matrix)


@pytest.mark.slow
def test_a_declared_mass_matrix_is_kept() -> None:
    body, log = dive("torpedo", 180.0, 42)
    declared = {("surge", "surge"): float(body.mass[0, 0]), ("yaw", "yaw"): float(body.mass[5, 5])}
    found = identify(on_grid([log]), declared=declared)
    assert found.vehicle.mass["surge", "surge"].to_dict()["origin"] == "declared"
    assert found.vehicle.mass_matrix[5, 5] == body.mass[5, 5]
    assert not found.unseen


def test_a_vehicle_that_nothing_drives_is_refused_with_the_cure() -> None:
    _, log = dive("torpedo", 60.0, 43)
    motion = on_grid([{name: stream for name, stream in log.items() if "force" not in name and name != "torque"}])
    with pytest.raises(BadInput, match="--column surge_force=NAME"):
        identify(motion)


@pytest.mark.parametrize("seconds", [20.0, 60.0])
def test_too_short_a_dive_is_refused_without_a_length_that_moves(seconds: float) -> None:
    """A longer dive shows slower motion and needs longer windows: a figure would grow with the dive that follows it."""
    _, log = dive("torpedo", seconds, 44)
    motion = on_grid([log])
    with pytest.raises(BadInput, match="give longer or more recordings") as refused:
        identify(motion)
    assert re.findall(r"[\d.]+ s\b", str(refused.value)) == [f"{motion.seconds:.3g} s"]


def test_a_dive_of_a_second_is_refused_without_a_length_that_moves() -> None:
    _, log = dive("torpedo", 1.0, 44)
    with pytest.raises(BadInput, match="give longer recordings") as refused:
        on_grid([log])
    assert not re.findall(r"\d", str(refused.value))


def test_a_lag_that_is_simulated_in_cells_is_the_exact_one() -> None:
    command = np.repeat([0.0, 1.0, -0.5], 40)
    fine = np.repeat(command, 100)
    exact, value = np.empty(fine.size), 0.0
    for k, level in enumerate(fine):
        mean = level + (value - level) * (0.3 / 0.001) * (1.0 - np.exp(-0.001 / 0.3))
        value = level + (value - level) * np.exp(-0.001 / 0.3)
        exact[k] = mean
    assert lagged(command, 0.3, 0.1) == pytest.approx(exact.reshape(-1, 100).mean(axis=1), abs=1e-9)


def test_slopes_are_those_of_simulations_with_each_parameter_moved() -> None:
    body, log = dive("rov", 30.0, 47)
    motion = on_grid([log])
    names = ("surge", "sway", "heave", "roll", "pitch", "yaw")
    mass = (*((name, name) for name in names), ("surge", "pitch"))
    terms = (*own_damping(names), *restoring(names, motion.recorded), *extras(names, names, motion.recorded))
    structure = Structure(names, mass, terms, ("surge", "yaw"), np.zeros((6, 6)))
    damping = [(body.linear if term.kind == "linear" else body.quadratic)[term.row] for term in own_damping(names)]
    rest = [0.05] * (len(terms) - len(damping))
    parameters = np.array([*np.diag(body.mass), body.mass[0, 4], *damping, *rest, 0.2, 0.1])
    first = motion.windows(12)[:6]
    found = sensitivities(structure, parameters, np.full(2, 1e-6), motion, first, 12)
    shift = 1e-6 * np.maximum(np.abs(parameters), 1.0)
    ahead, behind = (simulate(structure, parameters + k * np.diag(shift), motion, first, 12) for k in (1.0, -1.0))
    expected = (ahead - behind)[1:] / (2.0 * shift[:, None, None])
    assert found == pytest.approx(expected.transpose(1, 2, 0, 3), abs=1e-5 * float(np.abs(expected).max()))


def test_a_window_whose_slopes_run_away_near_a_pitch_of_90_degrees_outweighs_no_other() -> None:
    body, log = dive("rov", 60.0, 4)
    motion = on_grid([log])
    first = int(motion.windows(12)[20])
    motion.angle[first : first + 13, 1] = 1.4
    motion.effort[first : first + 12, 4] = 5.0
    names = ("surge", "sway", "heave", "roll", "pitch", "yaw")
    terms = (*own_damping(names), *restoring(names, motion.recorded))
    structure = Structure(names, tuple((name, name) for name in names), terms, (), np.zeros((6, 6)))
    damping = [(body.linear if term.kind == "linear" else body.quadratic)[term.row] for term in own_damping(names)]
    # A search that is still far off: too light and too little righted about pitch.
    inertia = np.diag(body.mass) * np.where(np.arange(6) == 4, 0.3, 1.0)
    parameters = np.array([*inertia, *damping, 0.3 * body.righting, 0.3 * body.righting, 0.1])
    windows = Windows(motion, motion.windows(12), 12)
    raw = np.abs(sensitivities(structure, parameters, np.empty(0), motion, windows.first, 12)).max(axis=(0, 2, 3))
    kept = np.abs(slopes(windows, structure, parameters, np.abs(parameters))).max(axis=(0, 2, 3))
    away = raw > 1e6 * np.median(raw)
    assert np.count_nonzero(away) == 1
    assert kept[~away] == pytest.approx(raw[~away])
    assert (kept[away] == 0.0).all()


def test_a_gap_ends_a_run() -> None:
    _, log = dive("torpedo", 60.0, 45)
    cut = {name: (np.delete(t, slice(200, 260)), np.delete(v, slice(200, 260))) for name, (t, v) in log.items()}
    assert len(on_grid([cut]).runs) == 2


def test_a_motion_without_damping_keeps_its_energy() -> None:
    """C(ν) ν does no work."""
    body, log = dive("rov", 20.0, 46)
    motion = on_grid([log])
    names = ("surge", "sway", "heave", "roll", "pitch", "yaw")
    structure = Structure(names, (), (), (), body.mass)
    still = replace(motion, effort=0.0 * motion.effort, effort_rise=0.0 * motion.effort)
    course = simulate(structure, np.empty((1, 0)), still, np.array([30]), 20)[:, 0, 0]
    energy = 0.5 * np.einsum("ki,ij,kj->k", course, body.mass, course)
    assert energy == pytest.approx(energy[0], rel=1e-3)
