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
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from incsvr.effects.effect import Term
from incsvr.tracing.findings import Finding
from incsvr.tracing.model import TracedModel
from service.bus.session import free_endpoint
from service.cli.command_line import main
from service.export.command import in_format
from service.export.damping_model import DampingModel, of_file
from service.recordings.recording_csv import write
from simulator import leng
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
        terms=(Term("torque_lag", "torque_lag", (0.3,), ()),), sigma=0.4, block=1.0, scale=2.0, origin=(0.0, 1.0),
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


def elements(text: str) -> ET.Element:
    """A fragment as it stands in a file of the tool."""
    return ET.fromstring(f"<file>{text}</file>")


def opposes(moment: Any, learned: DampingModel) -> None:
    """The moment about yaw of a tool is the damping that was learned, against the turn."""
    rate = learned.curve.rate
    assert np.array([moment(r) for r in rate]) == pytest.approx(-learned.curve.damping, abs=1e-4)


def test_gazebo_reads_derivatives(traced: Path) -> None:
    learned = of_file(traced)
    text = in_format(learned, "gazebo", "base_link", dry=15.0)
    (plugin,) = elements(text)
    assert plugin.attrib == {"filename": "gz-sim-hydrodynamics-system", "name": "gz::sim::systems::Hydrodynamics"}
    told = {child.tag: child.text for child in plugin}
    assert told.keys() == {"link_name", "nR", "nRabsR", "nDotR"}
    values = {name: float(value or "") for name, value in told.items() if name != "link_name"}
    # As Hydrodynamics.cc has it: the wrench is −(Dmat ν) with Dmat = −nR − nRabsR |r|, and + Ma ν̇.
    opposes(lambda r: -((-values["nR"] - values["nRabsR"] * abs(r)) * r), learned)
    assert 15.0 - values["nDotR"] == pytest.approx(INERTIA)
    assert "torque_lag, dead_zone, torque_asymmetry" in text


def test_uuv_simulator_reads_six_and_thirty_six_numbers(traced: Path) -> None:
    learned = of_file(traced)
    text = in_format(learned, "uuv", "rov/base_link", dry=15.0)
    (link,) = elements(text)
    model = link.find("hydrodynamic_model")
    assert link.attrib == {"name": "rov/base_link"}
    assert model is not None
    assert model.findtext("type") == "fossen"
    mass, linear, quadratic = (
        [float(value) for value in (model.findtext(name) or "").split()]
        for name in ("added_mass", "linear_damping", "quadratic_damping")
    )
    assert (len(mass), len(linear), len(quadratic)) == (36, 6, 6)
    # As HydrodynamicModel.cc has it: D = −linear − quadratic |ν|, the moment is −D ν − Ma ν̇.
    opposes(lambda r: -((-linear[5] - quadratic[5] * abs(r)) * r), learned)
    assert 15.0 + mass[35] == pytest.approx(INERTIA)
    assert sum(map(abs, mass)) == mass[35]
    assert "<type>FirstOrder</type><timeConstant>0.3</timeConstant>" in text


def test_stonefish_gets_what_it_can_hold_and_is_told_the_rest(traced: Path) -> None:
    learned = of_file(traced)
    text = in_format(learned, "stonefish", "", across=(2.0, 21.0))
    inertia, rotor = elements(text)
    assert inertia.attrib == {"xyz": "2 21 24"}
    assert rotor.attrib == {"type": "first_order"}
    assert rotor.find("time_constant") is not None
    assert float(rotor[0].attrib["value"]) == 0.3
    assert "no place for N_r" in text
    assert "dead_zone, torque_asymmetry" in text


def test_python_vehicle_simulator_gets_a_module_that_its_vehicles_take(traced: Path) -> None:
    learned = of_file(traced)
    module: dict[str, Any] = {}
    exec(in_format(learned, "python-vehicle-simulator", ""), module)
    vehicle = SimpleNamespace(M=np.eye(6), Minv=np.eye(6), D=np.eye(6), T_n=1.0)
    module["put_into"](vehicle)
    # As its vehicles have it: tau_damp = −D ν, and what is quadratic beside it.
    opposes(lambda r: -vehicle.D[5, 5] * r + module["quadratic_yaw_damping"](r), learned)
    assert np.linalg.inv(vehicle.Minv)[5, 5] == pytest.approx(INERTIA)
    assert vehicle.T_n == 0.3
    assert (module["DEAD_BAND"], module["REVERSE_EFFICIENCY"], module["THRUST_DELAY"]) == (0.6, 0.8, None)


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


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--format", "stonefish", "LAGLESS"], "has no place for N_r"),
        (["--format", "gazebo", "--dry-inertia", "30", "TRACE"], "must have less than the 24 kg m²"),
        (["--format", "uuv", "--dry-inertia", "-1", "TRACE"], "-1 is no moment of inertia"),
        (["EMPTY"], "this contains no learned damping"),
        (["no_such.json"], "cannot be read"),
        (["FOLDER"], "there is no such state"),
        (["TRACE", "--out", "no/such/folder.xml"], "name a file in a folder that is there with --out"),
    ],
)
def test_what_cannot_be_exported_is_said(
    words: list[str], sentence: str, traced: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lagless, empty = tmp_path / "lagless.json", tmp_path / "empty.json"
    lagless.write_text(json.dumps(json.loads(traced.read_text()) | {"effects": []}))
    empty.write_text("{}")
    places = {"TRACE": traced, "LAGLESS": lagless, "EMPTY": empty, "FOLDER": tmp_path}
    assert main(["export", *(str(places.get(word, word)) for word in words)]) == 2
    said = capsys.readouterr()
    assert sentence in said.err
    assert said.err.count("\n") == 1
    assert said.out == ""
