"""A log of a simulated vehicle along several axes, for those who have none yet."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import simulator.dive_log
from incsvr.plant.axes import EFFORTS, VELOCITIES
from service.cli.command_line import main
from service.recordings.reading import read
from simulator.dive_log import write_dive


def test_the_logs_of_two_seeds_are_dives_of_one_vehicle(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(simulator.dive_log, "LOG_DURATION_S", 20.0)
    one, two = tmp_path / "one.csv", tmp_path / "two.csv"
    assert main(["demo", "--log", str(one), "--log-of", "rov"]) == 0
    body = write_dive(two, "rov", 2)
    assert f"surge {body.mass[0, 0]:.3g}, sway {body.mass[1, 1]:.3g}" in capsys.readouterr().out
    streams, others = read(one).streams(), read(two).streams()
    assert {*VELOCITIES, *EFFORTS, "roll", "pitch", "heading"} == {*streams}
    assert not np.array_equal(streams["surge_force"][1], others["surge_force"][1])


def test_another_vehicle_plays_no_experiment(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["demo", "--log-of", "rov"]) == 2
    assert "--log FILE.csv" in capsys.readouterr().err
