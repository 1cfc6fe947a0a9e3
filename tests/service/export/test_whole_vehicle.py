"""A whole vehicle read back as each tool reads it: by its own formulas, signs and names, and simulated by them."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from incsvr.numerics import Array
from incsvr.plant.mass_and_coriolis import coriolis_matrix
from incsvr.plant.terms import Term
from incsvr.vehicle import Parameter, Vehicle
from service.cli.command_line import main
from service.config.vehicle_file import write_vehicle
from service.export.formats import python_module
from simulator.vehicles import NAMES
from tests.vehicle_of_body import own_damping

STEP_S, STEPS = 0.05, 120
PORT_AND_UP = np.array([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])
"""From axes to starboard and down into Gazebo's."""


def known(value: float, origin: str = "estimated") -> Parameter:
    return Parameter(value, value, value, origin)


def vehicle_with(terms: dict[Term, float], lags: dict[str, float] | None = None) -> Vehicle:
    """A small ROV whose M couples surge with pitch, sway with roll, and heave with surge."""
    mass = {(name, name): known(value) for name, value in zip(NAMES, (18.0, 24.0, 28.0, 0.3, 0.4, 0.6), strict=True)}
    mass |= {("surge", "pitch"): known(0.4), ("sway", "roll"): known(-0.3), ("surge", "heave"): known(1.5)}
    values = [8.0, 35.0, 12.0, 60.0, 14.0, 75.0, 0.3, 0.5, 0.4, 0.6, 0.5, 0.9]
    damping = dict(zip(own_damping(NAMES), values, strict=True))
    parameters = {term: known(value) for term, value in {**damping, **terms}.items()}
    lagged = {name: known(value) for name, value in (lags or {}).items()}
    return Vehicle("rov", NAMES, NAMES, mass, parameters, lagged, np.full(6, 0.8))


CROSS = {Term("yaw", "cross", ("sway",)): 1.3, Term("heave", "cross", ("pitch_rate",)): -0.7}
AHEAD = {Term("sway", "product", ("surge", "yaw_rate")): 4.0, Term("heave", "product", ("surge", "pitch_rate")): 2.5}
OTHERS = {
    Term("surge", "product", ("sway", "yaw_rate")): -3.0,
    Term("pitch", "product", ("sway", "roll_rate")): 0.3,
    Term("heave", "square", ("sway",)): 2.0,
    Term("pitch", "cross_size", ("heave", "pitch_rate")): 0.8,
    Term("pitch", "cross_size", ("yaw_rate", "pitch_rate")): 0.2,
}


def exported(tmp_path: Path, vehicle: Vehicle, name: str, *words: str) -> str:
    """What `incsvr export` writes of it."""
    write_vehicle(tmp_path / "rov.yaml", vehicle)
    target = tmp_path / "out"
    assert main(["export", str(tmp_path / "rov.yaml"), "--format", name, "--out", str(target), *words]) == 0
    return target.read_text(encoding="utf-8")


def space_of(text: str) -> dict[str, Any]:
    space: dict[str, Any] = {}
    exec(text, space)
    return space


def free_run(acceleration: Callable[[Array, Array], Array], efforts: Array) -> Array:
    """(n + 1, 6) velocities from rest by small Runge-Kutta steps."""
    velocity, parts = np.zeros(6), 2
    course = [velocity]
    for effort in efforts:
        for _ in range(parts):
            h, slopes, at = STEP_S / parts, [], velocity
            for ahead in (0.5, 0.5, 1.0, 1.0):
                slopes.append(acceleration(at, effort))
                at = velocity + ahead * h * slopes[-1]
            velocity = velocity + h / 6.0 * (slopes[0] + 2.0 * slopes[1] + 2.0 * slopes[2] + slopes[3])
        course.append(velocity)
    return np.array(course)


def commands() -> Array:
    levels = np.random.default_rng(531).uniform(-1.0, 1.0, (STEPS // 12, 6)) * [30.0, 30.0, 30.0, 1.0, 1.0, 2.0]
    return np.repeat(levels, 12, axis=0)


def agrees(acceleration: Callable[[Array, Array], Array], vehicle: Vehicle, sign: Array | float = 1.0) -> None:
    """A tool's own equations, in its own axes, give the free run of our Python export, upright."""
    space = space_of(python_module(vehicle))
    ours = free_run(lambda v, effort: np.asarray(space["acceleration"](v, effort, np.zeros(2))), commands())
    assert np.ptp(ours, axis=0).min() > 0.3
    assert free_run(acceleration, commands() * sign) * sign == pytest.approx(ours, abs=1e-6)


def model_of(text: str) -> ET.Element:
    """The model in Gazebo's world."""
    model = ET.fromstring(text).find("world/model")
    assert model is not None
    return model


def number(element: ET.Element, path: str) -> float:
    return float(element.findtext(path) or "0")


def gazebo_body(file: ET.Element) -> Array:
    """M as gz-physics takes it: the body's mass and moments, and the entries of <fluid_added_mass> (inertial.sdf)."""
    inertial, letters = file.find("link/inertial"), "xyzpqr"
    assert inertial is not None
    mass = np.diag([number(inertial, "mass")] * 3 + [number(inertial, f"inertia/i{a}{a}") for a in "xyz"])
    for row in range(6):
        for column in range(row, 6):
            value = number(inertial, f"fluid_added_mass/{letters[row]}{letters[column]}")
            mass[row, column] += value
            mass[column, row] += value if row != column else 0.0
    return mass


def gazebo_wrench(plugin: ET.Element, velocity: Array) -> Array:
    """The plugin's wrench without added mass and Coriolis, as HydrodynamicsUtils.hh and Hydrodynamics.cc have it."""
    drag = np.zeros((6, 6))
    for i, force in enumerate("xyzkmn"):
        for j, own in enumerate("UVWPQR"):
            drag[i, j] = -number(plugin, force + own)
            for k, other in enumerate("UVWPQR"):
                drag[i, j] -= number(plugin, f"{force}{own}abs{other}") * abs(velocity[k])
                drag[i, j] -= number(plugin, force + own + other) * velocity[k]
    return -(drag @ velocity)


@pytest.mark.parametrize("turned", [False, True])
def test_gazebo_moves_as_the_vehicle_file(tmp_path: Path, turned: bool) -> None:
    vehicle = vehicle_with({**CROSS, **AHEAD, **OTHERS})
    file = model_of(exported(tmp_path, vehicle, "gazebo", *["--port-and-up"] * turned))
    mass, plugin = gazebo_body(file), file.find("plugin")
    assert plugin is not None
    assert [plugin.findtext(f"disable_{name}") for name in ("added_mass", "coriolis")] == ["true", "true"]
    inverse = np.linalg.inv(mass)

    def acceleration(v: Array, effort: Array) -> Array:
        return np.asarray(inverse @ (effort + gazebo_wrench(plugin, v) - coriolis_matrix(mass, v) @ v))

    agrees(acceleration, vehicle, 1.0 if turned else PORT_AND_UP)
    inertial = "link/inertial"
    assert number(file, f"{inertial}/fluid_added_mass/zz") == pytest.approx(
        28 - number(file, f"{inertial}/mass"), abs=1e-6
    )


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("words", [[], ["--dry-mass", "11.5"]])
def test_gazebos_gravity_and_buoyancy_hold_the_vehicle_as_the_file_does(
    tmp_path: Path, words: list[str], turned: bool
) -> None:
    """As Buoyancy.cc and SimulationFeatures.cc have them: ρ V g at the volume's centre, m g at the centre of mass."""
    weight, down = -3.0 if turned else 3.0, Rotation.from_euler("xyz", (0.3, -0.2, 0.0)).inv().apply([0.0, 0.0, -1.0])
    terms = {Term("roll", "righting"): 4.0, Term("pitch", "righting"): 4.0, Term("heave", "weight"): weight}
    vehicle = vehicle_with(terms)
    world = ET.fromstring(exported(tmp_path, vehicle, "gazebo", *words, *["--port-and-up"] * turned))
    link, gravity = "world/model/link/collision", 9.80665
    volume = np.prod([float(side) for side in (world.findtext(f"{link}/geometry/box/size") or "").split()])
    centre = np.array([float(each) for each in (world.findtext(f"{link}/pose") or "").split()[:3]])
    lift = -number(world, "world/plugin/uniform_fluid_density") * volume * gravity * down
    force = number(world, "world/model/link/inertial/mass") * gravity * down + lift
    assert force[2] == pytest.approx(3.0 * down[2], abs=1e-5)
    # A vehicle to starboard and down is pitched the other way for the same position in the world.
    space, pitch = space_of(python_module(vehicle)), -0.2 if turned else 0.2
    ours = -space["damping"](np.zeros(6), np.zeros(6), (0.3, pitch)) * (1.0 if turned else PORT_AND_UP)
    assert np.cross(centre, lift) == pytest.approx(ours[3:], abs=1e-5)


def test_what_a_format_cannot_hold_stands_in_the_file_and_on_standard_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    others = {Term("surge", "inflow", ("surge",)): 0.2, Term("heave", "square", ("sway",)): 2.0}
    vehicle = vehicle_with({**others, Term("roll", "righting"): 4.0, Term("heave", "weight"): 3.0}, {"yaw": 0.25})
    doubted = replace(vehicle, terms={**vehicle.terms, Term("roll", "quadratic"): known(0.1, "not excited")})
    for name, sentences in (
        ("gazebo", ["surge inflow:surge = 0.2", "Thrust lag of yaw: 0.25 s"]),
        ("stonefish", ["surge linear = 8 N s/m", "makes drag and added mass of the body's shape"]),
    ):
        text = exported(tmp_path, doubted, name)
        for place in (text, capsys.readouterr().err):
            for sentence in (*sentences, "roll quadratic (not excited)", "Weight less buoyancy: 3 N"):
                assert sentence in place, name
        ET.fromstring(text if name == "gazebo" else f"<file>{text}</file>")


def test_stonefish_holds_the_moments_of_body_and_water_and_the_centre_of_gravity(tmp_path: Path) -> None:
    vehicle = vehicle_with({Term("roll", "righting"): 4.0, Term("pitch", "righting"): 4.0}, {"yaw": 0.25})
    words = ["--dry-mass", "11.5", "--dry-inertia", "0.2", "--inertia-xy", "0.1", "0.15"]
    file = ET.fromstring(f"<file>{exported(tmp_path, vehicle, 'stonefish', *words)}</file>")
    values = {child.tag: child.attrib for child in file}
    assert values["mass"] == {"value": "11.5"}
    assert values["inertia"] == {"xyz": "0.3 0.4 0.6"}
    assert float(values["cg"]["xyz"].split()[2]) * 11.5 * 9.80665 == pytest.approx(4.0)
    assert float(file.findall("rotor_dynamics/time_constant")[0].attrib["value"]) == 0.25


def test_axes_that_were_not_identified_get_nothing_of_the_water(tmp_path: Path) -> None:
    whole = vehicle_with({})
    axes = ("surge", "sway", "yaw")
    mass = {pair: p for pair, p in whole.mass.items() if set(pair) <= set(axes)}
    planar = replace(
        whole, axes=axes, driven=axes, mass=mass, terms={t: p for t, p in whole.terms.items() if t.axis in axes}
    )
    text = exported(tmp_path, planar, "gazebo")
    assert np.diag(gazebo_body(model_of(text))) == pytest.approx([18.0, 24.0, 18.0, 0.6, 0.6, 0.6])
    assert "Not identified, and 0 here: added mass and damping of heave, roll, pitch" in text


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--dry-mass", "20"], "the body alone has 20 along surge, and body and water together 18"),
        (["--dry-inertia", "0.2"], "--dry-inertia and --inertia-xy together"),
        (["--dry-mass", "-1"], "-1 is no moment of inertia"),
    ],
)
def test_a_body_that_cannot_be_is_refused(
    tmp_path: Path, words: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    write_vehicle(tmp_path / "rov.yaml", vehicle_with({}))
    assert main(["export", str(tmp_path / "rov.yaml"), *words]) == 2
    assert sentence in capsys.readouterr().err
