"""`incsvr trace` from the command line: JSON by the contract, text for people, faults in one sentence."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from incsvr.numerics import Array
from service.cli.command_line import main
from service.recordings.recording import from_table
from service.recordings.recording_csv import write

LENG = ("--inertia", "350")


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two minutes of a plain vehicle with a trim moment of 12 N m that nobody declared."""
    random = np.random.default_rng(5)
    time = np.asarray(np.arange(0.0, 120.0, 0.05), dtype=np.float64)
    torque = 60.0 * np.sin(2 * np.pi * time / 31.0) + 35.0 * np.sin(2 * np.pi * time / 11.0)
    rate: Array = np.empty_like(time)
    now = 0.0
    for k, moment in enumerate(torque):
        rate[k] = now
        now += 0.05 * (moment + 12.0 - 120.0 * now - 700.0 * now * abs(now)) / 350.0
    path = tmp_path_factory.mktemp("trace") / "trim.csv"
    columns = {
        "yaw_rate": rate + random.normal(0.0, 2e-4, time.size),
        "torque": torque + random.normal(0.0, 3.5, time.size),
    }
    write(path, from_table("trim", time, columns))
    return path


def test_prints_one_json_object_and_the_text_beside_it(recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["trace", str(recording), *LENG, "--json", "-"]) == 0
    printed = capsys.readouterr()
    found = json.loads(printed.out)
    assert found["verdict"] == "effects"
    assert [effect["effect"] for effect in found["effects"]] == ["bias_torque"]
    told = [rejected["p_value"] for rejected in found["rejected"]]
    assert told == sorted(told)
    moment, (low, high) = (found["effects"][0][key]["moment_nm"] for key in ("parameters", "interval"))
    assert moment == pytest.approx(12.0, rel=0.03)
    assert low < moment < high
    # of means over blocks, the torque sensor's own noise is the floor, and the model reaches it
    assert 0.0 < found["error"]["floor"]["torque_rmse"] < 3.5
    assert found["error"]["after"]["torque_rmse"] < 1.1 * found["error"]["floor"]["torque_rmse"]
    assert "adding bias_torque lowers" in printed.err
    assert "held-out pieces" in printed.err


@pytest.mark.slow
def test_what_was_found_is_kept_where_the_report_cannot_be_written(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A full disk takes the picture, not the result."""
    report, kept = tmp_path / "full.html", tmp_path / "found.json"
    report.symlink_to("/dev/full")
    assert main(["trace", str(recording), *LENG, "--report", str(report), "--json", str(kept)]) == 2
    printed = capsys.readouterr()
    assert "full.html cannot be written (No space left on device)" in printed.err
    assert json.loads(kept.read_text(encoding="utf-8"))["headline"] in printed.out


@pytest.mark.slow
def test_an_inertia_that_is_far_too_small_has_a_report_of_one_file(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    report, kept = tmp_path / "small.html", tmp_path / "small.json"
    words = ["trace", str(recording), "--inertia", "30", "--report", str(report), "--json", str(kept)]
    assert main(words) == 0
    found = json.loads(kept.read_text(encoding="utf-8"))
    assert found["declared"]["inertia"] == 30.0
    assert found["inertia"] == pytest.approx(350.0, rel=0.15)
    assert "disagree by a factor" in found["limits"][0]
    page = report.read_text(encoding="utf-8")
    assert f"{found['inertia']:.3g} kg m² in use" in page
    assert "bias_torque" in page
    assert 'src="http' not in page


@pytest.mark.parametrize("validate", [[], ["--validate"]])
def test_the_same_data_twice_is_refused_whatever_its_name(
    recording: Path, validate: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    copy = tmp_path / "copy.csv"
    copy.write_bytes(recording.read_bytes())
    assert main(["trace", str(recording), *validate, str(copy), *LENG]) == 2
    assert "copy.csv holds the same data as trim.csv" in capsys.readouterr().err
    detour = recording.parent / ".." / recording.parent.name / recording.name
    assert main(["trace", str(recording), *validate, str(detour), *LENG]) == 2
    assert "trim.csv is given twice" in capsys.readouterr().err
