"""A vehicle file played by `incsvr simulate` and learned again by `incsvr serve`: real processes, a real bus."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.axes import VELOCITIES
from incsvr.vehicle import Vehicle
from service.bus.session import free_endpoint
from service.cli.command_line import main
from service.config.vehicle_file import write_vehicle
from service.recordings.reading import read
from service.recordings.recording import Recording
from service.recordings.recording_csv import write
from simulator.dive_log import dives
from simulator.vehicles import BODIES, NAMES
from simulator.whole_vehicle import moved_by
from tests.vehicle_of_body import vehicle_of

BODY = BODIES["torpedo"](np.random.default_rng(71))
VEHICLE = vehicle_of(BODY, (1.1, 0.5, 0.0, 0.0, 0.0, 0.5))


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a vehicle file and a dive of that vehicle."""
    folder = tmp_path_factory.mktemp("vehicle")
    write_vehicle(folder / "auv.yaml", VEHICLE)
    (log,) = dives([BODY], 100.0, 72, along=0.0, about=0.0)
    write(folder / "dive.csv", Recording("dive", log))
    return folder


def own_damping(vehicle: Vehicle, axis: str, rate: Array) -> Array:
    of = {term.kind: parameter.value for term, parameter in vehicle.terms.items() if term.axis == axis}
    return np.asarray(of["linear"] * rate + of["quadratic"] * rate * np.abs(rate))


def test_what_is_played_is_what_the_model_does_under_the_efforts(files: Path) -> None:
    words = ["simulate", "--vehicle", str(files / "auv.yaml"), "--commands", str(files / "dive.csv")]
    assert main([*words, "--to", "20", "--write", str(files / "played")]) == 0
    played = read(files / "played" / "whole.csv").streams()
    log = read(files / "dive.csv").streams()
    assert set(played) == {"surge", "sway", "yaw_rate", "roll", "pitch", "surge_force", "sway_force", "torque"}
    edges, course = VEHICLE.free_run({name: (t[:190], v[:190]) for name, (t, v) in log.items()}, 0.1)
    for name in ("surge", "sway", "yaw_rate"):
        coarse = course[:, VELOCITIES.index(name)]
        fine = np.interp(edges, *played[name])
        assert np.abs(fine - coarse).max() < 0.02 * np.abs(coarse).max()


def test_a_plan_holds_its_efforts_and_shows_where_the_vehicle_goes(files: Path) -> None:
    plan = files / "plan.csv"
    plan.write_text("t,surge_force,torque\n0,10,0\n4,10,2\n8,0,0\n", encoding="utf-8")
    words = ["simulate", "--vehicle", str(files / "auv.yaml"), "--commands", str(plan)]
    assert main([*words, "--write", str(files / "planned")]) == 0
    planned = read(files / "planned" / "whole.csv").streams()
    time, torque = planned["torque"]
    assert np.abs(torque - np.where(time < 4.0, 0.0, 2.0))[np.abs(time - 4.0) > 0.02].max() < 1e-9
    assert np.abs(planned["surge_force"][1] - 10.0).max() < 1e-9
    at, surge = planned["surge"]
    mass = BODY.mass[0, 0]
    assert surge[np.searchsorted(at, 0.5)] == pytest.approx(10.0 / mass * 0.5, rel=0.05)
    assert planned["yaw_rate"][1][-1] > 0.1
    plan.write_text("t,surge_force,torque\n0,10,0\n4,x,2\n", encoding="utf-8")
    assert main(words) == 2


def test_a_log_without_efforts_is_refused_with_the_cure() -> None:
    with pytest.raises(BadInput, match=r"--column surge_force=NAME .*--column torque=NAME"):
        moved_by({"yaw_rate": (np.array([0.0, 1.0, 2.0]), np.zeros(3))}, VEHICLE, "log")


def test_nothing_is_played_without_commands(files: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", "--vehicle", str(files / "auv.yaml")]) == 2
    assert "--commands LOG" in capsys.readouterr().err
    assert main(["simulate", "--commands", str(files / "dive.csv")]) == 2
    assert "give one, --vehicle FILE" in capsys.readouterr().err


@pytest.mark.slow
def test_serve_learns_the_damping_of_the_file_that_simulate_plays(files: Path) -> None:
    """Each curve within 5 % of the damping at the fastest velocity: what the filter and 160 samples leave."""
    endpoint = free_endpoint()
    shared = ["--vehicle", str(files / "auv.yaml")]
    settings = ["--set", "state=null", "--set", "learner.batch=20", "--listen", endpoint]
    run = [sys.executable, "-m", "service.cli.command_line"]
    serving = subprocess.Popen([*run, "serve", *shared, *settings], stderr=subprocess.DEVNULL)
    try:
        played = ["simulate", *shared, "--commands", str(files / "dive.csv"), "--connect", endpoint, "--speed", "60"]
        assert main(played) == 0
        for axis in ("surge", "sway", "yaw"):
            asked = _answer(files, ["query", "--connect", endpoint, "--prefix", f"leng/{axis}"], _rates(axis))
            rate = np.array(asked["rate"])
            wrong = np.array(asked["damping"]) - own_damping(VEHICLE, axis, rate)
            largest = own_damping(VEHICLE, axis, np.array([VEHICLE.fastest[NAMES.index(axis)]]))[0]
            assert not any(asked["extrapolated"]), axis
            assert np.abs(wrong).max() < 0.05 * largest, axis
    finally:
        serving.terminate()
        serving.wait()


def _rates(axis: str) -> list[str]:
    """Velocities up to half of the fastest, which the dive reaches both ways."""
    return [f"{share * VEHICLE.fastest[NAMES.index(axis)]:.3f}" for share in (-0.5, -0.25, 0.0, 0.25, 0.5)]


def _answer(folder: Path, command: list[str], rates: list[str]) -> dict[str, list[float]]:
    assert main([*command, "--json", str(folder / "answer.json"), "--", *rates]) == 0
    answer: dict[str, list[float]] = json.loads((folder / "answer.json").read_text(encoding="utf-8"))
    return answer
