"""`incsvr fit --write`: a learner that starts from it does as well as `fit`, on the bus and from a file."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from service.bus.session import free_endpoint
from service.cli.command_line import main
from service.config.sources import read as read_config
from service.recordings.recording import Recording
from service.recordings.recording_csv import read as read_recording
from service.recordings.recording_csv import write
from simulator import leng
from tests.service.conftest import PATIENCE


def told(capsys: pytest.CaptureFixture[str], *words: str | Path) -> Any:
    assert main([*map(str, words), "--json", "-"]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.slow
def test_a_learner_that_starts_from_it_serves_the_curve_of_the_fit(
    capsys: pytest.CaptureFixture[str], measured: Path, tmp_path: Path
) -> None:
    runs, unseen = [measured / f"bluerov/run_0{n}.csv" for n in (3, 4)], measured / "bluerov/run_05.csv"
    written = tmp_path / "rov.yaml"
    words: list[str | Path] = [*runs, "--validate", unseen, "--inertia", "1.125"]
    fitted = told(capsys, "fit", *words, "--write", written)
    again = told(capsys, "fit", *words, "--config", written)
    deployed = told(capsys, "fit", *words, "--config", Path(__file__).parents[3] / "deploy" / "bluerov.yaml")
    assert max(each["validation"]["mae"] for each in (fitted, again, deployed)) < 0.63
    assert again["put_aside"] == deployed["put_aside"] == 0

    endpoint, rates = free_endpoint(), np.linspace(-1.5, 1.5, 31)
    words = ["--config", written, "--connect", endpoint]
    serve = ["serve", "--config", str(written), "--listen", endpoint, "--set", "state=null"]
    process = subprocess.Popen([sys.executable, "-m", "service.cli.command_line", *serve], stderr=subprocess.DEVNULL)
    try:
        played = [tmp_path / run.name for run in runs]
        for run, path in zip(runs, played, strict=True):  # without the channels, which nobody needs here
            whole = read_recording(run)
            write(path, Recording(run.name, whole.time, {name: whole.columns[name] for name in ("yaw_rate", "torque")}))
        assert main([*map(str, ["replay", *played, *words, "--speed", "100"])]) == 0
        until = time.monotonic() + PATIENCE
        while True:  # what has arrived is still to be learned
            capsys.readouterr()
            served = told(capsys, "query", *(f"{rate}" for rate in rates), *words)
            if served["iteration"] == again["iterations"]:
                break
            assert time.monotonic() < until
    finally:
        process.kill()
        process.wait()
    curve = np.interp(rates, again["curve"]["rate"], again["curve"]["damping"])
    assert np.asarray(served["damping"]) == pytest.approx(curve, abs=0.05)


@pytest.mark.slow
def test_what_is_written_is_what_was_scaled_and_said(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    run, first, second = tmp_path / "T1.csv", tmp_path / "first.yaml", tmp_path / "second.yaml"
    write(run, leng.recording("T1", 3))
    result = told(capsys, "fit", run, "--inertia", "350", "--policy", "weighted", "--write", first)
    config = read_config(first)
    assert config.vehicle.name == "T1"
    for name in ("gamma", "C", "epsilon", "near_rate", "near_damping"):
        assert getattr(config.learner, name) == pytest.approx(result["settings"]["learner"][name], rel=0.005)
    assert config.learner.policy == "weighted"
    assert config.signals.smoothing == pytest.approx(result["settings"]["signals"]["smoothing"], rel=0.005)
    told(capsys, "fit", run, "--config", first, "--inertia", "340", "--write", second)
    again = read_config(second)
    assert again.vehicle.inertia == 340.0
    assert again.learner == config.learner
    assert again.signals.sample_period == config.signals.sample_period


@pytest.mark.parametrize("words", [("fit", "--write"), ("tune", "--write"), ("identify", "--vehicle")])
def test_a_file_that_a_person_wrote_is_not_replaced(
    words: tuple[str, str], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    command, flag = words
    mine = tmp_path / "config.yaml"
    mine.write_text("prefix: leng/yaw  # mine\n")
    assert main([command, "no_such_run.csv", flag, str(mine)]) == 2
    assert f"config.yaml is not replaced, because incsvr did not write it; name another file with {flag}" in (
        capsys.readouterr().err
    )
    assert mine.read_text() == "prefix: leng/yaw  # mine\n"


def test_where_it_cannot_be_written_is_said_before_the_work(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["fit", "no_such_run.csv", "--write", str(tmp_path)]) == 2
    assert "name a file in a folder that is there with --write" in capsys.readouterr().err
