"""Leng's log for beginners, and manoeuvres as files."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import simulator.leng_at_sea
from incsvr.errors import BadInput
from service.cli.command_line import main
from service.recordings.manoeuvre import read_plan
from simulator import leng
from simulator.leng_at_sea import REVERSE_EFFICIENCY, write_log


def test_a_log_is_small_and_the_same_for_the_same_seed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simulator.leng_at_sea, "LOG_DURATION", 60.0)
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


@pytest.mark.parametrize(
    ("text", "reason"),
    [
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
        read_plan(path)
