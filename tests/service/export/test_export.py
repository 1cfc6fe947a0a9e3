"""What was learned, read back as each tool reads it: by its own formulas, signs and names."""

from __future__ import annotations

import csv
import io
import json
import subprocess
import sys
import time
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from incsvr.tracing.findings import Finding
from incsvr.tracing.model import TracedModel
from incsvr.vehicle import Parameter, Vehicle
from service.bus.session import free_endpoint
from service.cli.command_line import main
from service.config.vehicle_file import write_vehicle
from service.export.command import in_format
from service.export.learned import Learned, of_file
from service.recordings.recording_csv import write
from simulator import leng
from tests.hidden import lag
from tests.service.conftest import PATIENCE

LINEAR, QUADRATIC, INERTIA = 9.0, 26.0, 24.0
ITERATIONS = 14
"""As many as the Leng's T1 gives."""


@pytest.fixture
def traced(tmp_path: Path) -> Path:
    """What `incsvr trace --json` writes of a vehicle whose damping has exactly the textbook's form."""
    rate = np.linspace(-0.4, 0.5, 181)
    model = TracedModel(
        inertia=20.0, rate=rate, damping=LINEAR * rate + QUADRATIC * rate * np.abs(rate),
        effects=(lag(0.3),), sigma=0.4, block=1.0, scale=2.0, origin=(0.0, 1.0),
    )  # fmt: skip
    found = [
        ("torque_lag", {"time_constant_s": 0.3}, {"time_constant_s": (0.25, 0.35)}, ()),
        ("inertia", {"inertia_kg_m2": INERTIA}, {"inertia_kg_m2": (23.0, 25.0)}, ("thrust_efficiency",)),
        ("dead_zone", {"half_width_nm": 0.6}, {"half_width_nm": (0.5, 0.7)}, ()),
        ("torque_asymmetry", {"reverse_efficiency": 0.8}, {"reverse_efficiency": (0.7, 0.9)}, ()),
    ]
    effects = [
        Finding(name, ("torque",), parameters, spans, 1e-9, 0.3, rivals, "", "").to_dict()
        for name, parameters, spans, rivals in found
    ]
    path = tmp_path / "trace.json"
    path.write_text(json.dumps({"model": model.to_dict(), "effects": effects}))
    return path


def opposes(moment: Any, learned: Learned) -> None:
    """The moment about yaw of a tool is the damping that was learned, against the turn."""
    assert np.array([moment(r) for r in learned.rate]) == pytest.approx(-learned.damping, abs=1e-4)


def test_gazebo_reads_derivatives(traced: Path) -> None:
    learned = of_file(traced)
    text, _ = in_format(learned, "gazebo", about_yaw=15.0)
    inertial, plugin = (ET.fromstring(text).find(f"world/model/{path}") for path in ("link/inertial", "plugin"))
    assert inertial is not None
    assert plugin is not None
    assert plugin.attrib == {"filename": "gz-sim-hydrodynamics-system", "name": "gz::sim::systems::Hydrodynamics"}
    # As Hydrodynamics.cc has it: the wrench is −(Dmat ν) with Dmat = −nR − nRabsR |r|.
    values = {name: float(plugin.findtext(name) or "") for name in ("nR", "nRabsR")}
    opposes(lambda r: -((-values["nR"] - values["nRabsR"] * abs(r)) * r), learned)
    parts = [float(inertial.findtext(path) or "") for path in ("inertia/izz", "fluid_added_mass/rr")]
    assert parts == pytest.approx([15.0, INERTIA - 15.0])
    assert "dead_zone: half_width_nm = 0.6, which is not in this model" in text
    assert "This format cannot hold: yaw reverse = 0.2" in text


def test_python_moves_as_the_effects_say(traced: Path) -> None:
    learned, module = of_file(traced), dict[str, Any]()
    exec(in_format(learned, "python")[0], module)
    opposes(lambda r: -module["damping"](np.array([0, 0, 0, 0, 0, r]), np.zeros(6), (0.0, 0.0))[5], learned)
    push = np.array([0.0, 0.0, 0.0, 0.0, 0.0, -10.0])
    assert module["acceleration"](np.zeros(6), push, (0.0, 0.0))[5] == pytest.approx(-8.0 / INERTIA)
    assert (module["THRUST_LAG_S"], module["ROTORS"]) == ({5: 0.3}, [])


def test_a_lag_of_rotors_stays_one(traced: Path) -> None:
    found = json.loads(traced.read_text())
    found["effects"][0]["shape"] = "rotor speed"
    traced.write_text(json.dumps(found))
    module = dict[str, Any]()
    exec(in_format(of_file(traced), "python")[0], module)
    assert (module["THRUST_LAG_S"], module["ROTORS"]) == ({5: 0.3}, [5])
    pushed = module["lagged"](np.tile([0.0, 0.0, 0.0, 0.0, 0.0, 4.0], (40, 1)), 0.05)
    assert pushed[:, 5] == pytest.approx(4.0)


def test_tables_hold_figures_intervals_and_range(traced: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", str(traced), "--format", "csv"]) == 0
    rows = {row["quantity"]: row for row in csv.DictReader(io.StringIO(capsys.readouterr().out))}
    assert float(rows["N_r"]["estimate"]) == pytest.approx(LINEAR)
    assert float(rows["N_r|r|"]["estimate"]) == pytest.approx(QUADRATIC)
    assert (rows["inertia"]["estimate"], rows["inertia"]["low"], rows["inertia"]["high"]) == ("24.0", "23.0", "25.0")
    assert (rows["rate_low"]["estimate"], rows["rate_high"]["estimate"]) == ("-0.4", "0.5")
    assert rows["torque_lag.time_constant_s"]["high"] == "0.35"
    assert float(rows["form_error_rms"]["estimate"]) < 1e-9


@pytest.mark.slow
def test_a_running_learner_and_its_state_tell_the_same(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run, whole = tmp_path / "T1.csv", leng.recording("T1", 3)
    write(run, whole)
    endpoint, state = free_endpoint(), tmp_path / "state"
    serve = ["serve", "--listen", endpoint, "--set", f"state={state}"]
    process = subprocess.Popen([sys.executable, "-m", "service.cli.command_line", *serve], stderr=subprocess.DEVNULL)
    try:
        assert main(["replay", str(run), "--connect", endpoint, "--speed", "200"]) == 0
        until, running = time.monotonic() + PATIENCE, {"source": ""}
        while f"revision {ITERATIONS}," not in running["source"]:  # what has arrived is still to be learned
            assert time.monotonic() < until, running["source"]
            assert main(["export", "--connect", endpoint, "--out", str(tmp_path / "running.json")]) == 0
            running = json.loads((tmp_path / "running.json").read_text())
        capsys.readouterr()
        assert main(["export", str(state)]) == 0
    finally:
        process.kill()
        process.wait()
    kept = json.loads(capsys.readouterr().out)
    assert kept | {"source": ""} == running | {"source": ""}
    assert kept["inertia"]["estimate"] == leng.INERTIA
    low, high = (kept["coefficients"]["N_r|r|"][end] for end in ("low", "high"))
    assert low < kept["coefficients"]["N_r|r|"]["estimate"] < high
    rate, damping = np.array(kept["curve"]["rate"]), np.array(kept["curve"]["damping"])
    form = kept["coefficients"]["N_r"]["estimate"] * rate + kept["coefficients"]["N_r|r|"]["estimate"] * rate * abs(
        rate
    )
    assert np.sqrt(np.mean((form - damping) ** 2)) == pytest.approx(kept["form_error_rms"])


@pytest.fixture
def beaten(traced: Path) -> Path:
    """A trace whose free run no motion at all beats on unseen data."""
    found = json.loads(traced.read_text()) | {"error": {"best": {"name": "zero", "free_run_rmse": 0.01}}}
    traced.write_text(json.dumps(found))
    return traced


def test_a_model_that_a_velocity_of_zero_beats_is_not_exported(
    beaten: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["export", str(beaten)]) == 2
    said = capsys.readouterr()
    assert "a velocity of zero predicts unseen data better than this model" in said.err
    assert "with --force" in said.err
    assert said.out == ""
    file = beaten.with_suffix(".yaml")
    inertia, none = {("yaw", "yaw"): Parameter(1.0, 0.9, 1.1)}, dict[Any, Parameter]()
    write_vehicle(file, Vehicle("rov", ("yaw",), ("yaw",), inertia, none, none, np.ones(6), beaten_by="hold"))
    assert main(["export", str(file)]) == 2
    assert "the first velocity kept predicts unseen data better" in capsys.readouterr().err


def test_but_with_force_it_is(beaten: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", str(beaten), "--force"]) == 0
    assert json.loads(capsys.readouterr().out)["inertia"]["estimate"] == INERTIA


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (
            ["--format", "gazebo", "--dry-inertia", "30", "TRACE"],
            "the body alone has 30 along yaw, and body and water together 24",
        ),
        (["--format", "gazebo", "--dry-inertia", "-1", "TRACE"], "-1 is no moment of inertia"),
        (["--format", "uuv", "TRACE"], "--format uuv was removed; take gazebo"),
        (["--format", "python-vehicle-simulator", "TRACE"], "was removed; take python"),
        (["--link", "hull", "TRACE"], "replace base_link"),
        (["EMPTY"], "this contains no learned damping"),
        (["no_such.json"], "cannot be read"),
        (["FOLDER"], "there is no such state"),
        (["TRACE", "--out", "no/such/folder.xml"], "name a file in a folder that is there with --out"),
    ],
)
def test_what_cannot_be_exported_is_said(
    words: list[str], sentence: str, traced: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    empty = tmp_path / "empty.json"
    empty.write_text("{}")
    places = {"TRACE": traced, "EMPTY": empty, "FOLDER": tmp_path}
    try:
        status: object = main(["export", *(str(places.get(word, word)) for word in words)])
    except SystemExit as ended:
        status = ended.code
    assert status == 2
    said = capsys.readouterr()
    assert sentence in said.err
    assert said.err.count("\n") == 1
    assert said.out == ""
