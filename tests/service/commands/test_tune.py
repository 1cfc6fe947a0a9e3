"""`incsvr tune` from the command line: the simulated Leng, recordings, what is written, and bad input."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from service.cli.command_line import main
from service.config.sources import read as read_config
from service.recordings.recording import from_table
from service.recordings.recording_csv import write
from simulator import leng


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The first 40 s of Leng's T1, and the same of a vehicle a hundredth as heavy that turns four times as fast."""
    folder, whole = tmp_path_factory.mktemp("tune"), leng.recording("T1", 3100)
    few = whole.time < 40.0
    columns = {name: values[few] for name, values in whole.columns.items()}
    slow, quick = folder / "slow.csv", folder / "quick.csv"
    write(slow, from_table("slow", whole.time[few], columns))
    scaled = {"yaw_rate": 4.0 * columns["yaw_rate"], "torque": columns["torque"] / 100.0}
    write(quick, from_table("quick", whole.time[few], scaled))
    return slow, quick


@pytest.fixture(scope="module")
def slow(runs: tuple[Path, Path]) -> Any:
    path = runs[0].with_suffix(".json")
    config = runs[0].with_name("tuned.yaml")
    words = ["tune", str(runs[0]), "--inertia", "350", "--write", str(config), "--json", str(path)]
    assert main(words) == 0
    return json.loads(path.read_text(encoding="utf-8")), config


@pytest.mark.slow
def test_every_point_has_its_rank(slow: Any) -> None:
    result, _ = slow
    trials = result["trials"]
    assert [trial["rank"] for trial in trials] == list(range(1, 65))
    assert sorted(trial["rank_otherwise"] for trial in trials) == list(range(1, 65))
    errors = [trial["mae_every_step"] for trial in trials]
    assert errors == sorted(errors)
    (paper,) = [trial for trial in trials if trial["paper"]]
    assert (paper["C"], paper["epsilon"], paper["gamma"]) == (1000.0, 0.1, 10.0)  # Leng's grid is the paper's own


@pytest.mark.slow
def test_what_is_written_is_a_configuration_with_the_best_point(slow: Any) -> None:
    result, path = slow
    config = read_config(path)
    learner = config.learner_settings()
    assert {"C": learner.C, "epsilon": learner.epsilon, "gamma": learner.gamma} == result["best"]
    assert config.vehicle.inertia == 350.0
    assert config.vehicle.name == "leng"
    assert config.vehicle.torque_limit > 100.0
    assert 0.2 < config.vehicle.rate_range[1] < 0.3


@pytest.mark.slow
def test_the_grid_follows_the_vehicle(runs: tuple[Path, Path], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["tune", str(runs[1]), "--inertia", "0.875", "--last", "--json", "-"]) == 0
    said = capsys.readouterr()
    result = json.loads(said.out)
    (paper,) = [trial for trial in result["trials"] if trial["paper"]]
    assert (paper["C"], paper["epsilon"]) == (10.0, 0.001)
    assert paper["gamma"] == pytest.approx(10.0 / 5.0**2)  # four times as fast, to the round number beside it
    errors = [trial["mae_last_step"] for trial in result["trials"]]
    assert errors == sorted(errors)
    lines = said.err.splitlines()
    assert max(map(len, lines)) <= 80
    assert sum("paper's" in line for line in lines) == 1
    assert np.argmax(["paper's" in line for line in lines]) == paper["rank"] + 4
