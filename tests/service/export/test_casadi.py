"""The file for CasADi: it steps as our other simulators do, by NumPy and CasADi, and its Jacobians are its slopes."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from incsvr.numerics import Array
from incsvr.plant.axes import EFFORTS
from incsvr.plant.terms import Term
from incsvr.vehicle import Vehicle
from service.export.formats import python_module
from tests.service.export.test_whole_vehicle import (
    AHEAD,
    CROSS,
    OTHERS,
    STEP_S,
    commands,
    known,
    space_of,
    vehicle_with,
)

RESTORING = {
    Term("roll", "righting"): 4.0, Term("heave", "weight"): 3.0, Term("yaw", "bias"): 0.1,
    Term("yaw", "coulomb", ("0.05",)): 0.1, Term("sway", "bend", ("0.2",)): 3.0, Term("sway", "reverse"): 0.1,
}  # fmt: skip
STAGES = {"exponent": 1.4, "full_effort": 20.0, "dead_zone": 1.0, "limit": 15.0, "reverse": 0.7, "delay_s": 0.12}


@pytest.fixture
def vehicle() -> Vehicle:
    """A small ROV with every kind of term, lags of thrust and of rotors, and an axis whose commands are bent, limited
    and late."""
    whole = vehicle_with({**CROSS, **AHEAD, **OTHERS, **RESTORING}, {"surge": 0.3, "yaw": 0.15})
    of = {name: known(value) for name, value in STAGES.items()}
    sway = {"rotor_lag_s": known(0.2)}
    return replace(whole, thrust={"surge": of, "sway": sway, "heave": {"delay_s": known(2 * STEP_S)}})


def run(space: dict[str, Any], step: Any, efforts: Array) -> Array:
    """(n + 1, 6) velocities from rest."""
    x = space["start"](np.zeros(6), efforts[0], STEP_S)
    course = [x[:6]]
    for effort in efforts:
        x = np.array(step(x, effort)).ravel()
        course.append(x[:6])
    return np.array(course)


def test_its_numpy_steps_as_the_python_export(vehicle: Vehicle) -> None:
    space, ours = space_of(python_module(vehicle, casadi=True)), space_of(python_module(vehicle))
    course = run(space, lambda x, u: space["step"](x, u, STEP_S), commands())
    assert np.ptp(course, axis=0).min() > 0.3
    assert course == pytest.approx(ours["free_run"](np.zeros(6), commands(), STEP_S), abs=1e-9)
    assert space["LIMITS"] == {0: 15.0}
    assert space["DELAY_S"] == {0: 0.12, 2: 2 * STEP_S}


def test_casadi_steps_alike(vehicle: Vehicle) -> None:
    pytest.importorskip("casadi", reason="casadi is not installed: pip install casadi")
    space = space_of(python_module(vehicle, casadi=True))
    rates, step = space["casadi_functions"](STEP_S)
    course = run(space, step, commands())
    assert course == pytest.approx(run(space, lambda x, u: space["step"](x, u, STEP_S), commands()), abs=1e-9)
    x, u = space["start"](course[40], commands()[40], STEP_S)[: rates.size1_in(0)], commands()[41]
    assert np.array(rates(x, u)).ravel() == pytest.approx(np.array(space["f"](x, u)), abs=1e-9)


def test_its_jacobians_are_slopes(vehicle: Vehicle) -> None:
    space = space_of(python_module(vehicle, casadi=True))
    x = np.concatenate((np.linspace(0.3, 0.5, 6), [0.1, -0.05, 6.0, 1.0, 3.0]))
    u, h = np.array([9.0, 12.0, -14.0, 0.6, -0.7, 1.5]), 1e-5
    by_x, by_u = space["jacobians"](x, u)
    for matrix, at in ((by_x, lambda e: (x + e, u)), (by_u, lambda e: (x, u + e))):
        for column, e in enumerate(h * np.eye(matrix.shape[1])):
            ends = [np.array(space["f"](*at(by))) for by in (e, -e)]
            assert matrix[:, column] == pytest.approx((ends[0] - ends[1]) / (2.0 * h), abs=1e-5)


def test_it_simulates_as_the_vehicle_does(vehicle: Vehicle) -> None:
    efforts = commands()
    time: Array = np.linspace(0.0, STEP_S * len(efforts), len(efforts) + 1)
    held: Array = np.vstack((efforts, efforts[-1:]))
    log = {name: (time, held[:, k]) for k, name in enumerate(EFFORTS)}
    _, course = vehicle.free_run(log, STEP_S, held=True)
    space = space_of(python_module(vehicle, casadi=True))
    found = run(space, lambda x, u: space["step"](x, u, STEP_S), efforts)
    assert found == pytest.approx(course, abs=1e-9)


def test_it_runs_by_itself(vehicle: Vehicle, tmp_path: Path) -> None:
    for casadi in (False, True):
        file = tmp_path / "model.py"
        file.write_text(python_module(vehicle, casadi), encoding="utf-8")
        ran = subprocess.run([sys.executable, file], capture_output=True, text=True, check=True)
        assert [line.partition(":")[0] for line in ran.stdout.splitlines()] == list(vehicle.axes)
