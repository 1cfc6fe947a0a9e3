"""A log for beginners, and manoeuvres as files: read, played."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import simulator.steered
from incsvr.errors import BadInput
from service.cli.command_line import main
from service.commands.trace import runs_of
from service.recordings.manoeuvre import read_manoeuvre
from service.recordings.recording_csv import read
from simulator import leng
from simulator.steered import MAX_TORQUE, REVERSE_EFFICIENCY, steered, write_log


def test_a_log_is_small_and_the_same_for_the_same_seed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simulator.steered, "LOG_DURATION", 60.0)
    logs = [tmp_path / f"{name}.csv" for name in ("one", "again", "other")]
    assert [main(["demo", "--log", str(log), "--seed", seed]) for log, seed in zip(logs, "112", strict=True)] == [0] * 3
    one, again, other = (log.read_bytes() for log in logs)
    assert one == again != other
    assert len(one) < 1_000_000 / 5  # of five minutes a megabyte


@pytest.mark.slow
def test_what_is_hidden_in_the_log_is_found(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    fitted, unseen = tmp_path / "dive.csv", tmp_path / "other.csv"
    for seed, path in enumerate((fitted, unseen), start=1):
        assert write_log(path, seed) == leng.INERTIA
    assert main(["trace", str(fitted), "--validate", str(unseen), "--inertia", "350", "--json", "-"]) == 0
    (effect,) = json.loads(capsys.readouterr().out)["effects"]
    assert effect["effect"] == "torque_asymmetry"
    low, high = effect["interval"]["reverse_efficiency"]
    assert low < REVERSE_EFFICIENCY < high


def test_the_vehicle_does_what_the_file_says(tmp_path: Path) -> None:
    path, out = tmp_path / "turn.csv", tmp_path / "out"
    path.write_text("t,torque\n0,60\n40,-30\n80,0\n", encoding="utf-8")
    assert main(["simulate", "--torque", str(path), "--write", str(out)]) == 0
    recording = read(out / "turn.csv")
    (run,) = runs_of([recording])
    middle = {
        level: (recording.time > begin) & (recording.time < begin + 20.0) for level, begin in ((60, 20.0), (-30, 60.0))
    }
    for level, here in middle.items():
        assert np.nanmean(run.torque[here]) == pytest.approx(level, rel=0.25)  # the turn takes some of the thrust
        rate = float(np.nanmean(run.yaw_rate[here]))
        assert leng.damping(rate) == pytest.approx(float(np.nanmean(run.torque[here])), rel=0.1)
    assert recording.time[-1] == pytest.approx(80.0, abs=0.1)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "row 1: a manoeuvre has the columns"),
        ("t,moment\n0,1\n", "row 1: a manoeuvre has the columns"),
        ("t,torque\n0,1\n", "at least two rows"),
        ("t,torque\n0,1\n1,x\n", "row 3: t and torque must be two numbers"),
        ("t,torque\n0,1\n1\n", "row 3: t and torque must be two numbers"),
        ("t,torque\n0,1\nnan,1\n", "row 3: t and torque must be two numbers"),
        ("t,torque\n0,1\n2,1\n1,1\n", "row 4: t does not increase"),
    ],
)
def test_a_file_that_is_no_manoeuvre_is_refused(text: str, reason: str, tmp_path: Path) -> None:
    path = tmp_path / "next.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(BadInput, match=reason):
        read_manoeuvre(path)


def test_more_torque_than_the_vehicle_has_is_refused() -> None:
    with pytest.raises(BadInput, match="scale the manoeuvre down"):
        steered("x", np.array([0.0, 1.0]), np.array([2.0 * MAX_TORQUE, 0.0]), 1)


def test_a_missing_manoeuvre_says_how_one_is_made(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", "--torque", str(tmp_path / "none.csv"), "--write", str(tmp_path)]) == 2
    assert "the columns t [s] and torque [N m]" in capsys.readouterr().err
