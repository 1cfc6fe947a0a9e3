"""A whole vehicle: refusals, the file's terms and thrust in the engine, and C(ν) that a vehicle does without."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.model.fitting import Problem, fit
from incsvr.model.identification import structure_of
from incsvr.model.intervals import Interval
from incsvr.model.rows import free_products, mirrored, own, restoring, with_others
from incsvr.model.simulation import predict
from incsvr.model.structure import is_logarithm
from incsvr.model.windows import cut
from incsvr.numerics import Array, Streams
from incsvr.plant.axes import AXES, EFFORTS, VELOCITIES
from incsvr.plant.terms import Term
from incsvr.vehicle import Parameter, identify
from incsvr.vehicle.of_fit import _without_coriolis, vehicle_of
from incsvr.vehicle.runs import prepared
from service.config.vehicle_file import read_vehicle, write_vehicle
from service.export.formats import python_module
from simulator.vehicles import BODIES
from tests import vehicle_of_body
from tests.worlds import swim


def dive(kind: str, seconds: float, seed: int) -> Streams:
    """The log of a dive of a body drawn by the seed."""
    return swim(BODIES[kind](np.random.default_rng(seed)), seconds, seed)


def test_a_vehicle_that_nothing_drives_is_refused_with_the_cure() -> None:
    log = dive("torpedo", 60.0, 43)
    with pytest.raises(BadInput, match="--column surge_force=NAME"):
        identify([{name: stream for name, stream in log.items() if name not in EFFORTS}])


@pytest.mark.parametrize(("seconds", "words"), [(10.0, "longer or more recordings"), (1.0, "longer recordings")])
def test_too_short_a_dive_is_refused_without_a_length_that_moves(seconds: float, words: str) -> None:
    """A longer dive shows slower motion: a figure would grow with the dive that follows it."""
    with pytest.raises(BadInput, match=f"give {words}") as refused:
        identify([dive("torpedo", seconds, 44)])
    assert len(re.findall(r"[\d.]+ s\b", str(refused.value))) == (seconds > 5.0)


def test_a_long_pause_ends_a_run() -> None:
    log = dive("torpedo", 60.0, 44)
    paused = {name: (t[(t < 20.0) | (t > 30.0)], v[(t < 20.0) | (t > 30.0)]) for name, (t, v) in log.items()}
    assert [round(float(run["surge"][0][-1]) - float(run["surge"][0][0])) for run in prepared([paused])] == [20, 30]


@pytest.mark.parametrize("tied", [True, False])
def test_every_row_of_the_engine_moves_a_vehicle_file_alike(tied: bool, tmp_path: Path) -> None:
    """Six axes with one row of each kind, of C(ν) of M or without it, written and read."""
    rng, log = np.random.default_rng(7), dive("rov", 20.0, 7)
    plain = structure_of([log], VELOCITIES)
    more = [each for axis in VELOCITIES for each in own(axis, 0.5, axis in plain.driven)]
    more += [each for axis in VELOCITIES for each in with_others(axis, [v for v in VELOCITIES if v != axis], True)]
    chosen = {each.name.partition(":")[0] + each.axis: each for each in more if mirrored(each)}
    rows = (*plain.rows, *chosen.values(), *(() if tied else free_products(VELOCITIES)))
    rows = tuple({each.key: each for each in rows}.values())
    assert restoring(VELOCITIES, ("roll", "pitch"))[0].key in {each.key for each in rows}
    structure = replace(
        plain, rows=rows, tied=tied, coupled=(("surge", "pitch_rate"),), shift_priors={},
        stages=(
            ("dead", "surge"), ("limit", "yaw_rate"), ("reverse", "heave"), ("lag", "sway"), ("exponent", "sway"),
            ("spin", "roll_rate"),
        ),
        ways=dict.fromkeys(plain.driven, "hold"),
    )  # fmt: skip
    theta = {name: float(rng.normal(0.0, 0.1)) for name in structure.names}
    theta |= {f"mass:{axis}": np.log(m) for axis, m in zip(VELOCITIES, (20.0, 25.0, 30.0, 2.0, 3.0, 4.0), strict=True)}
    theta |= {each.key: 3.0 for each in rows if each.name == "linear"}
    theta |= {
        "dead:surge": 1.0,
        "limit:yaw_rate": 0.5,
        "reverse:heave": -0.3,
        "lag:sway": -1.0,
        "exponent:sway": 0.2,
        "spin:roll_rate": -1.2,
    }
    windows = cut([log], structure, 0.0125, np.inf)
    fitted = fit(structure, theta, Problem(windows), rounds=0)
    known = {n: Interval(v, v, v, 0.0) for n, v in ((n, _own(n, v)) for n, v in fitted.theta.items())}
    found = vehicle_of("rov", fitted, known, {}, np.full(6, 1.0))
    write_vehicle(tmp_path / "rov.yaml", found)
    again = read_vehicle(tmp_path / "rov.yaml")
    column = np.array([fitted.theta[name] for name in structure.names])[:, None]
    wanted = predict(structure, column, windows, windows.starts[:, None])[:, 0].reshape(6, -1).T
    _, course = again.free_run(log, windows.step)
    assert course[8::8] == pytest.approx(wanted, abs=1e-5)
    assert ("heave" in again.thrust) == any(t.kind == "inflow" and t.axis == "heave" for t in again.terms)


def _own(name: str, value: float) -> float:
    return float(np.exp(value)) if is_logarithm(name) else value


def test_the_python_export_passes_an_effort_through_all_stages_of_thrust() -> None:
    body = BODIES["torpedo"](np.random.default_rng(71))
    plain = vehicle_of_body.vehicle_of(body, (1.1, 0.5, 0.0, 0.0, 0.0, 0.5))
    values = {"exponent": 1.4, "full_effort": 40.0, "dead_zone": 3.0, "limit": 25.0, "reverse": 0.7, "delay_s": 0.25}
    stages = {name: Parameter(value, value, value) for name, value in values.items()}
    lags = {"surge": Parameter(0.4, 0.4, 0.4)}
    friction = {Term("surge", "coulomb", ("0.05",)): Parameter(0.8, 0.8, 0.8)}
    vehicle = replace(plain, thrust={"surge": stages}, lags=lags, terms={**plain.terms, **friction})
    log = {name: stream for name, stream in swim(body, 30.0, 72).items() if name in EFFORTS}
    edges, course = vehicle.free_run(log)
    space: dict[str, object] = {}
    exec(python_module(vehicle), space)
    efforts: Array = np.array([log[n][1][:-1] if n in log else np.zeros(edges.size - 1) for n in EFFORTS]).T
    exported = space["free_run"]
    assert callable(exported)
    assert exported(np.zeros(6), efforts, edges[1] - edges[0]) == pytest.approx(course, abs=0.02)
    assert np.abs(course - plain.free_run(log)[1])[:, 0].max() > 0.1


def test_what_rounding_leaves_of_a_product_is_no_term() -> None:
    diagonal = zip(AXES, (36.32, 4.693, 1011.0, 0.0017, 7.688, 8.182), strict=True)
    entries = {(axis, axis): value for axis, value in diagonal}
    entries |= {("surge", "heave"): 3.598, ("surge", "pitch"): 0.5909, ("heave", "pitch"): -1.429}
    entries |= {("sway", "roll"): 0.0013, ("sway", "yaw"): 0.6835, ("roll", "yaw"): -7.5e-4}
    known = {pair: Parameter(value, 0.9 * value, 1.1 * value) for pair, value in entries.items()}
    found = _without_coriolis(known, VELOCITIES)
    assert {"product", "square"} == {term.kind for term in found}
    assert min(abs(each.value) for each in found.values()) > 1e-6
