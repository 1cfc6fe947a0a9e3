"""The learners in a vehicle file: one for each axis that it has an actuator for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from incsvr.errors import BadInput
from incsvr.vehicle import Vehicle
from service.config.configuration import Config, check_inertia
from service.config.sources import read
from service.config.vehicle_file import read_vehicle, write_vehicle
from service.export.formats import python_module
from simulator.vehicles import BODIES, NAMES
from tests.vehicle_of_body import vehicle_of

ROV = vehicle_of(BODIES["rov"](np.random.default_rng(61)))
BOAT = vehicle_of(BODIES["boat"](np.random.default_rng(61)), (1.0, 0.4, 0.0, 0.0, 0.0, 0.5))


def of_file(tmp_path: Path, vehicle: Vehicle, **values: Any) -> Config:
    """The configuration of a vehicle's file and of further values, with dots in their names."""
    write_vehicle(tmp_path / "vehicle.yaml", vehicle)
    return read(None, values, vehicle=tmp_path / "vehicle.yaml")


def test_each_axis_with_an_actuator_has_a_learner_in_its_own_units(tmp_path: Path) -> None:
    config = of_file(tmp_path, ROV)
    check_inertia(config)
    learners = config.each()
    assert [each.prefix for each in learners] == [f"leng/{axis}" for axis in ("yaw", *NAMES[:-1])]
    for learner in learners:
        place, axis = NAMES.index(learner.vehicle.axis), learner.vehicle.axis
        fastest = float(ROV.fastest[place])
        assert (learner.vehicle.name, learner.vehicle.inertia) == ("rov", ROV.mass_matrix[place, place])
        assert learner.vehicle.rate_range == (-fastest, fastest)
        assert learner.learner.gamma * fastest**2 == pytest.approx(Config().learner.gamma * 0.25**2, rel=0.01)
        coupled = learner.coupled()
        assert coupled is not None
        assert coupled.missing == ()
        angles = {"roll": np.array([0.3]), "pitch": np.array([-0.2])}
        force = coupled.restoring(angles, 1)
        righting = {"roll": np.sin(0.3) * np.cos(0.2), "pitch": np.sin(-0.2)}.get(axis)
        if righting is None:
            assert force is None
        else:
            assert force == pytest.approx(BODIES["rov"](np.random.default_rng(61)).righting * righting)


def test_the_velocity_of_an_axis_without_actuators_comes_as_a_channel(tmp_path: Path) -> None:
    yaw, surge = of_file(tmp_path, BOAT, prefix="fleet/boat").each()
    assert (yaw.prefix, surge.prefix) == ("fleet/boat/yaw", "fleet/boat/surge")
    assert set(yaw.signals.channels) == {"surge", "sway"}
    assert set(surge.signals.channels) == {"sway", "body_yaw_rate"}


def test_what_the_configuration_says_goes_before_what_the_file_says(tmp_path: Path) -> None:
    further = {"surge": {"vehicle": {"rate_limit": 9.0}}, "o": {"prefix": "other/yaw", "vehicle": {"name": "other"}}}
    config = of_file(tmp_path, BOAT, prefix="boat/yaw", learner={"policy": "weighted", "batch": 7}, learners=further)
    yaw, surge, other = config.each()
    assert {(each.learner.policy, each.learner.batch) for each in (yaw, surge)} == {("weighted", 7)}
    assert (surge.prefix, surge.vehicle.rate_limit, other.prefix) == ("boat/surge", 9.0, "other/yaw")
    assert surge.learner.gamma != yaw.learner.gamma


def test_the_section_of_a_file_is_one_of_the_configuration(tmp_path: Path) -> None:
    expected = of_file(tmp_path, ROV, prefix="auv")
    section = (tmp_path / "vehicle.yaml").read_text(encoding="utf-8").partition("\nlearners:")
    (tmp_path / "config.yaml").write_text(f"prefix: auv{''.join(section[1:])}", encoding="utf-8")
    again = read(tmp_path / "config.yaml")
    assert again == expected
    assert [each.prefix for each in again.each()] == [f"auv/{axis}" for axis in ("yaw", *NAMES[:-1])]


def test_a_file_without_actuators_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="no axis of this vehicle has an actuator"):
        of_file(tmp_path, replace(ROV, driven=()))


@pytest.mark.parametrize(
    ("edit", "told"),
    [
        (lambda file: file.pop("fastest"), "fastest: Field required"),
        (lambda file: file.update(name=None), "name: "),
        (lambda file: file.update(name="two\nlines"), "a name is one line of text"),
        (lambda file: file.update(axes=["surge", "up"]), "axes"),
        (lambda file: file["axes"].remove("surge"), "driven names surge, which is not among axes"),
        (lambda file: file["fastest"].update(yaw=-1.0), r"fastest\.yaw"),
        (lambda file: file["fastest"].update(yaw=0.0), r"fastest\.yaw is 0"),
        (lambda file: file["fastest"].pop("heave"), "fastest lacks heave"),
        (lambda file: file["mass_matrix"].pop("yaw,yaw"), "mass_matrix needs yaw,yaw above 0"),
        (lambda file: file["mass_matrix"].update({"yaw,yaw": {"value": -2.0}}), "mass_matrix needs yaw,yaw above 0"),
        (lambda file: file["mass_matrix"].update({"yaw,yaw": {"value": float("nan")}}), "finite number"),
        (lambda file: file["mass_matrix"].update({"yaw,yaw": {"value": None}}), r"yaw,yaw\.value"),
        (lambda file: file["mass_matrix"].update({"sway,yaw": {"value": 1e3}}), "belongs to no body"),
        (lambda file: file["mass_matrix"].update({"pitch,surge": {"value": 0.1}}), "it is symmetric: keep one"),
        (lambda file: file["mass_matrix"].update({"yaw,up": {"value": 0.1}}), "mass_matrix has no entry yaw,up"),
        (lambda file: file["terms"]["yaw"].update(cubic={"value": 1.0}), "yaw has no term cubic"),
        (lambda file: file["terms"]["yaw"].update({"cross:up": {"value": 1.0}}), "yaw has no term cross:up"),
        (lambda file: file["terms"]["yaw"].update(righting={"value": 1.0}), "yaw has no term righting"),
        (lambda file: file["terms"]["yaw"].update(linear={"value": -1.0}), r"terms\.yaw\.linear is negative"),
        (lambda file: file.update(thrust_lag_s={"yaw": {"value": -0.1}}), r"thrust_lag_s\.yaw\.value"),
        (lambda file: file["terms"]["surge"]["linear"].update(unit="lbf s/ft"), "is in lbf s/ft; convert it to N s/m"),
        (lambda file: file["mass_matrix"]["yaw,yaw"].update(unit="slug ft²"), "convert it to kg m²"),
        (lambda file: file.update(thrust_lag_s={"yaw": {"value": 0.1, "unit": "ms"}}), "convert it to s"),
        (lambda file: file.update(thrust={"yaw": {"dead_zone": {"value": -1.0}}}), r"thrust\.yaw\.dead_zone\.value"),
        (
            lambda file: file.update(
                thrust_lag_s={"yaw": {"value": 0.1}}, thrust={"yaw": {"rotor_lag_s": {"value": 0.2}}}
            ),
            "yaw lags twice, by thrust_lag_s and by rotor_lag_s",
        ),
        (lambda file: file.update(thrust={"yaw": {"exponent": {"value": 1.5}}}), "exponent and full_effort belong"),
        (lambda file: file.update(thrust={"yaw": {"limit": {"value": 2.0, "unit": "N"}}}), "convert it to N m"),
        (lambda file: file["terms"]["yaw"]["linear"].update(low=3.0, high=2.0), r"low \(3\) is above high \(2\)"),
        (lambda file: file["terms"]["yaw"]["linear"].update(vaule=3.0), r"linear\.vaule: a vehicle file has no such"),
        (lambda file: file.update(masses={}), "masses: a vehicle file has no such entry"),
    ],
)
def test_a_vehicle_file_that_was_damaged_by_hand_is_refused_with_the_entry(
    tmp_path: Path, edit: Callable[[dict[str, Any]], object], told: str
) -> None:
    file = ROV.to_dict()
    edit(file)
    path = tmp_path / "vehicle.yaml"
    path.write_text(yaml.safe_dump(file), encoding="utf-8")
    for reading in (lambda: read(vehicle=path), lambda: read_vehicle(path)):
        with pytest.raises(BadInput, match=told) as refused:
            reading()
        assert str(refused.value).startswith(f"{path}: the vehicle file is incomplete or damaged: ")
        assert "\n" not in str(refused.value)


def test_a_file_of_a_newer_release_is_named(tmp_path: Path) -> None:
    path = tmp_path / "vehicle.yaml"
    path.write_text(yaml.safe_dump({**ROV.to_dict(), "vehicle_file": 2}), encoding="utf-8")
    for reading in (lambda: read(vehicle=path), lambda: read_vehicle(path)):
        with pytest.raises(BadInput, match="vehicle_file: 2, is newer than 1, which is read here; update incsvr"):
            reading()


@pytest.mark.parametrize("name", ["null", "true", "5", "Ünter", 'a "quoted" \\ name', "a/b: c # d", '"""'])
def test_any_name_comes_back_from_a_file_and_its_export_is_python(tmp_path: Path, name: str) -> None:
    write_vehicle(tmp_path / "vehicle.yaml", replace(BOAT, name=name))
    again = read_vehicle(tmp_path / "vehicle.yaml")
    assert again.name == name
    space: dict[str, Any] = {}
    exec(python_module(again), space)
    assert name in space["__doc__"]


def test_a_ship_has_limits_that_the_configuration_takes(tmp_path: Path) -> None:
    ship = ROV.to_dict()
    for axis in NAMES:
        ship["terms"][axis]["quadratic"]["value"] = 1e6
    assert of_file(tmp_path, Vehicle.from_dict(ship)).each()[0].vehicle.torque_limit == 1e7


def test_what_is_no_list_of_learners_is_refused(tmp_path: Path) -> None:
    wrong: tuple[Any, ...] = (3, [3], {"surge": 3}, {"surge": {"learners": {}}})
    for learners in wrong:
        with pytest.raises(BadInput, match="learners"):
            of_file(tmp_path, BOAT, learners=learners)


def test_a_mistake_in_a_learner_of_the_file_is_said(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="vehicle: Input should be a valid"):
        of_file(tmp_path, BOAT, learners={"surge": {"vehicle": 3}})
    with pytest.raises(BadInput, match=r"there is no learner\.gama"):
        of_file(tmp_path, BOAT, learners={"surge": {"learner": {"gama": 3.0}}})
