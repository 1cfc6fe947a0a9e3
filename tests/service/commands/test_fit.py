"""`incsvr fit` from the command line: right on Leng, honest on the measured vehicle, clear about bad input."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from service.cli.command_line import main
from service.config.sources import read
from service.recordings.recording import from_table
from service.recordings.recording_csv import write
from simulator import leng
from tests.worlds import planar


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Leng's runs as files."""
    folder = tmp_path_factory.mktemp("leng")
    paths = {name: folder / f"{name}.csv" for name in ("T1", "V1")}
    for name, path in paths.items():
        write(path, leng.recording(name, 0))
    return paths


def fit(capsys: pytest.CaptureFixture[str], *words: str | Path) -> dict[str, Any]:
    declared = () if {"--inertia", "--config"} & set(words) else ("--inertia", "350")
    assert main(["fit", *map(str, words), *declared, "--json", "-"]) == 0
    result: dict[str, Any] = json.loads(capsys.readouterr().out)
    return result


@pytest.fixture
def configured(tmp_path: Path) -> Path:
    path = tmp_path / "config.yaml"
    path.write_text("vehicle: {name: leng}\n", encoding="utf-8")
    return path


def test_the_leng_is_learned_from_files(
    capsys: pytest.CaptureFixture[str], recorded: dict[str, Path], configured: Path
) -> None:
    result = fit(capsys, recorded["T1"], "--validate", recorded["V1"], "--config", configured)
    assert result["iterations"] == len(result["validation_per_iteration"]) == 14
    assert result["inertia"] == 350.0
    assert result["support_vectors"] <= 60
    assert 3.0 < result["validation"]["mae"] < 4.0  # the noise alone is 3.1 N m
    assert 3.7 < result["validation"]["rmse"] < 5.0
    assert result["validation"]["free_run_rmse"] < 0.0100  # the gyro's noise is 0.0082 rad/s
    assert result["validation"] == result["validation_per_iteration"][-1] | {
        "free_run_rmse": result["validation"]["free_run_rmse"]
    }


@pytest.mark.slow
def test_the_inertia_is_estimated(capsys: pytest.CaptureFixture[str], recorded: dict[str, Path]) -> None:
    result = fit(capsys, recorded["T1"], "--inertia", "estimate")
    doubt = result["inertia_standard_error"]
    assert 8.0 < doubt < 26.0  # the water moves the vehicle: 10 to 25 kg m² in twelve other runs
    assert abs(result["inertia"] - 350.0) < 2.0 * doubt
    assert result["validation"] is None


@pytest.mark.slow
def test_a_gap_is_said_and_not_bridged(
    capsys: pytest.CaptureFixture[str], recorded: dict[str, Path], tmp_path: Path
) -> None:
    whole = leng.recording("T1", 0)
    kept = (whole.time < 100.0) | (whole.time > 130.0)
    path = tmp_path / "gap.csv"
    write(path, from_table("gap.csv", whole.time[kept], {name: v[kept] for name, v in whole.columns.items()}))
    result, spacing = fit(capsys, path), ("--set", "signals.sample_period=0.25")
    assert result["remarks"][0].startswith("gap.csv: yaw_rate pauses 1 times for longer than 0.2 s, 30 s in all")
    lost = fit(capsys, recorded["T1"], *spacing)["samples"] - fit(capsys, path, *spacing)["samples"]
    assert 30.0 / 0.25 <= lost < 35.0 / 0.25


@pytest.mark.slow
def test_the_measured_vehicle(capsys: pytest.CaptureFixture[str], measured: Path) -> None:
    """Trained on two yaw-only runs, judged on the third; an inertia that is estimated runs freer than the declared."""
    runs = [measured / "bluerov" / f"run_{number:02d}.csv" for number in (3, 4, 5)]
    declared, estimated = (
        fit(
            capsys,
            *runs[:2],
            "--validate",
            runs[2],
            "--inertia",
            inertia,
            "--policy",
            "paper",
            "--set",
            "signals.smoothing=0.2",
        )
        for inertia in ("1.125", "estimate")
    )
    assert declared["inertia"] == 1.125
    assert 0.9 < estimated["inertia"] < 1.2
    assert estimated["validation"]["free_run_rmse"] < declared["validation"]["free_run_rmse"] < 0.3
    assert estimated["validation"]["mae"] < 0.6


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("fit missing.csv --inertia 350", "missing.csv: there is no such file"),
        ("fit short.csv --inertia 350", "damping samples, but one batch needs 50; give more or longer recordings"),
        ("fit slow.csv --inertia 350", "slow.csv: not one damping sample; it is shorter than"),
        ("fit good.csv --inertia heavy", "--inertia is heavy; give the moment of inertia in kg m²"),
        ("fit good.csv --inertia -3", "--inertia is -3; give the moment of inertia"),
        ("fit good.csv --inertia nan", "--inertia is nan; give the moment"),
        (
            "fit degrees.csv --inertia 350",
            "row 12: yaw_rate is 14.3, beyond the plausible ±6 rad/s; if it is in degrees",
        ),
        ("fit still.csv --inertia 350", "zero in every sample; give recordings in which the vehicle turns"),
        ("fit still.csv --inertia estimate", "the inertia cannot be estimated: torque and yaw rate must change"),
        ("fit good.csv --inertia 350 --validate degrees.csv", "degrees.csv, row 12: yaw_rate is 14.3"),
        ("trace nowhere.csv", "no such file"),
        ("trace good.csv --inertia -3", "--inertia is -3; give the moment"),
        ("tune", "give recordings to tune on"),
        ("tune good.csv --simulated 1", "give recordings to tune on"),
        ("tune good.csv", "the inertia is not known; give --inertia"),
        ("tune good.csv --inertia -1", "--inertia is -1; give the moment of inertia"),
        (
            "tune good.csv --inertia 350 --write no/such/folder.yaml",
            "name a file in a folder that is there with --write",
        ),
    ],
)
def test_bad_input_is_one_sentence(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: str, message: str
) -> None:
    monkeypatch.chdir(tmp_path)
    time = np.arange(0.0, 60.0, 0.05, dtype=np.float64)
    rate = 0.2 * np.sin(time)
    degrees = rate.copy()
    degrees[10] = 14.3
    for name, column, size in (
        ("good", rate, 1200),
        ("short", rate, 60),
        ("slow", rate, 5),
        ("degrees", degrees, 1200),
        ("still", 0.0 * rate, 1200),
    ):
        columns = {"yaw_rate": column[:size], "torque": 50.0 * rate[:size]}
        write(Path(f"{name}.csv"), from_table(name, time[:size], columns))
    assert main(words.split()) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert message in captured.err
    assert captured.err.count("\n") == 1


def test_an_inertia_that_leaves_nothing_to_learn_is_named(
    capsys: pytest.CaptureFixture[str], recorded: dict[str, Path]
) -> None:
    """The gyro's noise, a hundredfold, hides all damping: no manoeuvre would help."""
    assert main(["fit", str(recorded["T1"]), "--inertia", "35000"]) == 2
    said = capsys.readouterr().err.strip()
    assert "declare the vehicle's own with --inertia" in said
    assert "\n" not in said


@pytest.mark.slow
def test_the_unseen_runs_are_not_cut_to_the_learned_ones(
    capsys: pytest.CaptureFixture[str], recorded: dict[str, Path], tmp_path: Path
) -> None:
    """Weak thrust in the learned run must not make strong thrust in the unseen one implausible."""
    whole = leng.recording("V1", 1)
    weak = tmp_path / "weak.csv"
    write(
        weak,
        from_table(
            "weak.csv", whole.time, {"yaw_rate": whole.columns["yaw_rate"], "torque": 0.3 * whole.columns["torque"]}
        ),
    )
    result = fit(capsys, weak, "--validate", recorded["T1"])
    assert result["rejected"] == {}
    assert result["validation"]["rmse"] > 40.0


@pytest.mark.slow
def test_the_report_of_a_fit_is_one_page_and_says_what_the_fit_says(
    capsys: pytest.CaptureFixture[str], recorded: dict[str, Path], tmp_path: Path
) -> None:
    page = tmp_path / "fit.html"
    result = fit(capsys, recorded["T1"], "--validate", recorded["V1"], "--inertia", "7000", "--report", page)
    text = page.read_text(encoding="utf-8")
    assert 'src="http' not in text
    assert text.count("<svg") >= 3
    for said in (
        "Fit: The damping was learned from",
        "T1.csv",
        f"from {result['samples']} samples",
        "times the torque",
    ):
        assert said in text
    for note in result["coefficient_notes"]:
        assert note in text


@pytest.mark.parametrize("name", ["rep.pdf", "rep", "rep.json"])
def test_a_report_of_another_form_is_refused_before_any_work(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, name: str
) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["fit", "nowhere.csv", "--inertia", "1", "--report", str(tmp_path / name)])
    assert f"the report is a page of HTML: name it {Path(name).with_suffix('.html')}" in capsys.readouterr().err


def test_values_that_are_set_are_in_force_over_scaled_and_configured_ones(
    capsys: pytest.CaptureFixture[str], recorded: dict[str, Path], tmp_path: Path
) -> None:
    values = {"learner.C": "77", "vehicle.rate_range": "[-0.3, 0.2]", "signals.smoothing": "0.15"}
    words = [word for key, value in values.items() for word in ("--set", f"{key}={value}")]
    path = tmp_path / "config.yaml"
    path.write_text("vehicle: {inertia: 350}\nsignals: {smoothing: 0.2, gap: 0.39}\n", encoding="utf-8")
    for over in ((), ("--config", path)):
        found = fit(capsys, recorded["T1"], *words, *over)["settings"]
        assert (found["learner"]["C"], found["learner"]["rate_range"]) == (77.0, [-0.3, 0.2])
        assert found["signals"]["smoothing"] == 0.15
        assert found["signals"]["gap"] <= 0.3, "a narrower filter bridges no longer pauses than it may"
    for text, why in {
        "bus.listen=tcp/x:1": "--set bus.listen: this command uses values of vehicle, signals, learner or inputs alone",
        "vehicle=3": "--set vehicle: name one value of the section",
        "vehicle.axis=sway": "give the axis by --axis",
        "vehicle.mass=3": "there is no vehicle.mass;",
    }.items():
        assert main(["fit", str(recorded["T1"]), "--inertia", "350", "--set", text]) == 2
        assert why in capsys.readouterr().err


@pytest.mark.slow
def test_damping_over_several_velocities_from_files(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """A part of the error, free runs that follow, and a configuration with which `serve` goes on."""
    runs = [tmp_path / f"{run}.csv" for run in (1, 2)]
    for run, path in enumerate(runs, start=1):
        write(path, planar(910130, 150.0, run, usual=True))
    words = (runs[0], "--validate", runs[1], "--policy", "weighted")
    alone = fit(capsys, *words)
    written = tmp_path / "several.yaml"
    over = fit(capsys, *words, "--set", "learner.inputs=yaw_rate,surge,sway", "--write", written, "--state", tmp_path)
    assert over["validation"]["rmse"] < 0.4 * alone["validation"]["rmse"]  # most of what is left is noise
    assert over["validation"]["free_run_rmse"] < 0.3 * alone["validation"]["free_run_rmse"]
    assert not any("coupled to others" in remark for remark in over["remarks"])
    assert read(written).further_inputs == ("surge", "sway")
    assert fit(capsys, runs[0], "--config", written)["iterations"] == over["iterations"]
    for inputs, what in (
        ("surge,yaw_rate", "begins with the axis's own"),
        ("yaw_rate,heave", "there is no channel heave"),
    ):
        assert main(["fit", str(runs[0]), "--inertia", "350", "--set", f"learner.inputs={inputs}"]) == 2
        assert what in capsys.readouterr().err
