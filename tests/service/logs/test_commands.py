"""`inspect`, `convert`, `fit` and `trace` on real logs, and on one that we make."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from service.cli.command_line import main
from service.recordings.reading import read
from tests.conftest import ROOT
from tests.service import link
from tests.service.logs.dive import BOOT, Dive, dive

NEVER = "was never armed, so there is nothing to learn from"
REAL = {
    "rov_never_armed.tlog": (
        {"ATTITUDE": (6210, 20.0), "SERVO_OUTPUT_RAW": (627, 2.0), "HEARTBEAT": (314, 1.0)},
        NEVER,
    ),
    "rov_on_deck.BIN": ({"IMU": (594, 25.0), "ATT": (237, 10.0), "RCOU": (237, 10.0)}, NEVER),
    "px4_simulated.ulg": (
        {
            "vehicle_angular_velocity": (1558, 50.0),
            "vehicle_torque_setpoint": (1558, 50.0),
            "actuator_motors": (313, 10.0),
        },
        "the torque is a fraction of full thrust, not N m, until its scale is given",
    ),
}
"""Counts and rates [Hz] of streams, and what is said where somebody wants to learn from it."""


def messages(truth: Dive) -> list[link.Said]:
    """What is on the link while it dives, with its parameters."""
    return link.in_order(link.parameters(), link.swum(truth))


def said(capsys: pytest.CaptureFixture[str], *words: str | Path, status: int = 0) -> Any:
    assert main([*map(str, words)]) == status
    shown = capsys.readouterr()
    return json.loads(shown.out) if status == 0 else shown.err


@pytest.mark.parametrize("name", REAL)
def test_real_logs_are_inspected(capsys: pytest.CaptureFixture[str], field_logs: Path, name: str) -> None:
    told = said(capsys, "inspect", field_logs / name, "--json", "-")
    streams = {each["name"]: each for each in told["streams"]}
    for topic, (count, rate) in REAL[name][0].items():
        assert streams[topic]["count"] == count
        assert streams[topic]["rate_hz"] == pytest.approx(rate, rel=0.02)
    assert told["proposal"]["yaw_rate"]["topic"] in REAL[name][0]
    assert told["armed"]["ever"] is (name == "px4_simulated.ulg")
    assert all(np.isfinite(ends).all() for each in told["streams"] for ends in each["ranges"].values())


@pytest.mark.parametrize(
    ("name", "command"), [*((name, "fit") for name in REAL), *(("rov_on_deck.BIN", name) for name in ("trace", "tune"))]
)
def test_nothing_is_learned_from_what_holds_nothing(
    capsys: pytest.CaptureFixture[str], field_logs: Path, name: str, command: str
) -> None:
    sentence = said(capsys, command, field_logs / name, "--inertia", "1.0", status=2)
    assert REAL[name][1] in sentence
    assert sentence.count("\n") == 1
    if name == "px4_simulated.ulg":
        assert "the yaw rate never exceeds its noise" in sentence
        sentence = said(
            capsys,
            command,
            field_logs / name,
            *("--inertia", "0.03", "--column", "torque=vehicle_torque_setpoint.xyz[2]*12"),
            status=2,
        )
        assert "the yaw rate never exceeds its noise" in sentence


def test_a_log_is_looked_at_in_80_columns(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = link.as_tlog(tmp_path / "dive.tlog", messages(dive()))
    assert main(["inspect", str(path)]) == 0
    shown = capsys.readouterr().out
    assert all(len(line) <= 80 for line in shown.splitlines() if not line.startswith("What next?"))  # to be copied
    assert "ATTITUDE" in shown
    assert "armed for 24.95 s" in shown
    assert main(["inspect", str(path), "--topic", "ATTITUDE"]) == 0
    assert "yawspeed" in capsys.readouterr().out
    assert "there is no topic ATTITUDES" in said(capsys, "inspect", path, "--topic", "ATTITUDES", status=2)


@pytest.mark.slow
def test_a_log_is_converted_and_learned_alike(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    truth = dive(seconds=120.0)
    log, out = link.as_dataflash(tmp_path / "dive.BIN", messages(truth)), tmp_path / "dive.csv"
    told = said(capsys, "convert", log, out, "--json", "-")
    assert told["values"]["yaw_rate"] == truth.time.size
    run = read(out)
    assert run.time[0] == BOOT
    np.testing.assert_allclose(run.streams()["torque"][1], truth.torque, atol=0.02)
    assert run.columns["armed"].min() == 0.0
    both = [said(capsys, "fit", path, "--inertia", "0.6", "--json", "-") for path in (log, out)]
    assert both[0]["curve"] == both[1]["curve"]
    assert both[0]["iterations"] > 3
    assert any("armed for 115 of 120 s" in remark for remark in both[0]["remarks"])


@pytest.mark.parametrize(
    ("files", "sentence"),
    [
        (("dive.BIN",), "name the logs first, then the CSV"),
        (("dive.BIN", "other.BIN"), "the last file is the one that is written"),
        (("dive.BIN", "nowhere/dive.csv"), "cannot be written; name a file in a folder that is there"),
        (("missing.BIN", "dive.csv"), "there is no such file"),
    ],
)
def test_what_cannot_be_converted(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, files: tuple[str, ...], sentence: str
) -> None:
    link.as_dataflash(tmp_path / "dive.BIN", messages(dive(seconds=8.0)))
    assert sentence in said(capsys, "convert", *(tmp_path / name for name in files), status=2)


def test_a_missing_package_is_one_sentence_with_the_install_that_works(tmp_path: Path) -> None:
    path = link.as_dataflash(tmp_path / "dive.BIN", messages(dive(seconds=8.0)))
    program = (
        "import sys; sys.modules['pymavlink'] = None; from service.cli.command_line import main; "
        "sys.exit(main(sys.argv[1:]))"
    )
    ran = subprocess.run(
        [sys.executable, "-c", program, "inspect", path], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert ran.returncode == 2
    assert "install it: pip install '.[logs]' in the checkout" in ran.stderr
    assert ran.stderr.count("\n") == 1


def test_the_learners_process_stays_light() -> None:
    heavy = "{'pyarrow', 'mcap', 'rosbags', 'pymavlink', 'pyulog', 'google'}"
    program = (
        f"import sys, service.commands.serve; sys.exit(any(name.partition('.')[0] in {heavy} for name in sys.modules))"
    )
    assert subprocess.run([sys.executable, "-c", program], cwd=ROOT, check=False).returncode == 0
