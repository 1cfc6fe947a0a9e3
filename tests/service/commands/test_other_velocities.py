"""A declared mass matrix in `fit`, and what is said where there is none: on a vehicle whose Coriolis force is known."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from incsvr.compensation.freeing import takes_torque
from incsvr.plant.axes import AXES, BODY_YAW_RATE
from incsvr.plant.body import CORIOLIS, Coupled
from incsvr.plant.mass_and_coriolis import mass_matrix
from incsvr.signals import synchronise
from service.cli.command_line import main
from service.config.sources import read
from service.recordings.recording_csv import write
from simulator import leng
from tests.hidden import recording
from tests.service.recordings.test_axes import CORIOLIS as SURGE_MASS
from tests.service.recordings.test_axes import MASS, vehicle

MATRIX = f"{SURGE_MASS},{MASS},0,0,0,5"
BODY = f"vehicle.mass_matrix={MATRIX}"
MEASURED = Path(__file__).parents[4] / "shared" / "measured" / "dagon"


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    folder = tmp_path_factory.mktemp("coupling")
    for seed in (900_300, 900_301):
        write(folder / f"{seed}.csv", vehicle(seed))
    return [str(folder / "900300.csv"), str(folder / "900301.csv")]


def fitted(capsys: pytest.CaptureFixture[str], files: list[str], *flags: str) -> tuple[dict[str, Any], str]:
    fit, unseen = files
    assert main(["fit", fit, "--validate", unseen, "--axis", "sway", *flags, "--json", "-"]) == 0
    out, told = capsys.readouterr()
    return json.loads(out), told


def test_a_declared_mass_matrix_takes_coriolis_out_of_the_damping(
    files: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    alone, of_alone = fitted(capsys, files, "--inertia", "60")
    freed, of_freed = fitted(capsys, files, "--set", BODY)
    assert freed["inertia"] == MASS
    assert freed["validation"]["free_run_rmse"] < 0.5 * alone["validation"]["free_run_rmse"]
    assert freed["validation"]["rmse"] < 0.5 * alone["validation"]["rmse"]
    assert freed["coupled"]["velocities"] == ["surge", "yaw_rate"]
    assert freed["coupled"]["taken_for_zero"] == []
    assert freed["coupled"]["share_of_torque"][CORIOLIS] > 0.15
    assert "coupled" not in alone
    assert "the axis is coupled to others: surge*yaw_rate takes about" in of_alone
    assert "of the force's" in of_alone
    assert "coupled to others" not in of_freed
    assert "the mass matrix is used with channel surge, channel yaw_rate" in of_freed


def test_what_is_not_recorded_is_zero_and_said(files: list[str], tmp_path: Path,
                                               capsys: pytest.CaptureFixture[str]) -> None:  # fmt: skip
    paths = []
    for seed in (900_300, 900_301):
        whole = vehicle(seed)
        streams = {name: stream for name, stream in whole.own_streams.items() if name != "surge"}
        write(tmp_path / f"{seed}.csv", replace(whole, own_streams=streams))
        paths.append(str(tmp_path / f"{seed}.csv"))
    result, told = fitted(capsys, paths, "--set", BODY)
    assert result["coupled"]["taken_for_zero"] == ["surge"]
    assert "assumed zero, because they are not recorded: channel surge" in told


@pytest.mark.slow
def test_a_trace_looks_at_what_the_body_leaves_of_the_force(
    files: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Without the matrix this vehicle's Coriolis force is what is found (tests/service/recordings/test_axes.py)."""
    trace, page = str(tmp_path / "trace.json"), tmp_path / "page.html"
    flags = ["--axis", "sway", "--set", BODY]
    assert main(["trace", files[0], "--validate", files[1], *flags, "--json", trace, "--report", str(page)]) == 0
    told, found = capsys.readouterr().out, json.loads(Path(trace).read_text())
    assert found["declared"]["inertia"] == MASS
    assert not [each["effect"] for each in found["effects"] if each["effect"].startswith("coriolis")]
    assert found["coupled"]["velocities"] == ["surge", "yaw_rate"]
    assert found["coupled"]["share_of_torque"][CORIOLIS] > 0.15
    assert "are subtracted from the force before tracing" in told
    assert "of the force's RMS: Coriolis" in told
    assert "Coriolis" in page.read_text()
    unseen = ["--validate", files[1], "--axis", "sway"]
    assert main(["fit", files[0], *unseen, "--set", BODY, "--effects", trace]) == 0
    capsys.readouterr()
    assert main(["fit", files[0], *unseen, "--inertia", "60", "--effects", trace]) == 2
    assert "traced with a mass matrix, and none is configured" in capsys.readouterr().err


def test_what_a_fit_writes_serve_learns_on_with(
    files: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "config.yaml"
    fitted(capsys, files, "--set", BODY, "--write", str(path), "--state", str(tmp_path))
    config = read(path)
    assert config.vehicle.inertia == MASS
    assert config.signals.channels == ("surge", BODY_YAW_RATE)
    body = config.coupled()
    assert body is not None
    assert (body.streams, body.missing) == (("surge", BODY_YAW_RATE), ())
    again, _ = fitted(capsys, files, "--config", str(path))
    assert again["coupled"]["taken_for_zero"] == []
    assert again["validation"]["free_run_rmse"] < 0.02


def test_yaw_by_itself_is_what_it_was_to_the_last_bit() -> None:
    """A body of which nothing but yaw moves gives the same samples as yaw alone, parts aside."""
    streams = recording(900_302, 100.0).streams()
    plain, _ = synchronise(leng.SIGNALS, streams)
    body = Coupled(AXES["yaw"], mass_matrix((900.0, 1200.0, 0.0, 0.0, 0.0, 350.0)), ())
    alone, _ = synchronise(leng.SIGNALS, streams, takes_torque(leng.SIGNALS, None, body))
    for name in ("time", "yaw_rate", "damping"):
        assert getattr(plain, name).tobytes() == getattr(alone, name).tobytes()
    assert plain.parts == {}
    assert not alone.parts[CORIOLIS].any()


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        (("--set", "vehicle.mass_matrix=1,2,three"), "unable to parse string as a number, not 'three'"),
        (("--set", "vehicle.mass_matrix=45,0,0,0,0,5"), "has 0 for sway"),
    ],
)
def test_what_cannot_be_used_is_one_sentence(
    files: list[str], flags: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    assert main(["fit", files[0], "--axis", "sway", *flags]) == 2
    assert said in capsys.readouterr().err


def test_a_measured_vehicle_in_sway(capsys: pytest.CaptureFixture[str]) -> None:
    """By itself its sway errs hardly less than zero does (0.10 m/s), and why is said: most of it is Coriolis."""
    if not MEASURED.is_dir():
        pytest.skip("the measured recordings are not in ../shared/measured")
    runs = [str(MEASURED / f"run_{number}.csv") for number in ("01", "03", "05", "07")]
    flags = ["--validate", str(MEASURED / "run_04.csv"), "--axis", "sway", "--json", "-"]
    assert main(["fit", *runs, "--inertia", "2500", *flags]) == 0
    alone = json.loads(capsys.readouterr().out)
    assert alone["validation"]["free_run_rmse"] > 0.07
    assert any("the axis is coupled to others: surge*yaw_rate" in remark for remark in alone["remarks"])
    assert main(["fit", *runs, "--set", "vehicle.mass_matrix=2200,2500,0,0,0,800", *flags]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["validation"]["free_run_rmse"] < 0.03
