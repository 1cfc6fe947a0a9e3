"""The demo as a process: what it plays, prints and leaves."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from pathlib import Path
from typing import Any

import psutil
import pytest

from benchmarks.repetition import repeat
from service.commands.demo_verdict import outcome, verdict
from service.wire import EffectsLedger
from tests.service.commands.test_processes import command
from tests.service.conftest import PATIENCE
from tests.viewer.readback import every


@pytest.mark.slow
def test_the_demo_plays_both_experiments_and_leaves_nothing_running(tmp_path: Path) -> None:
    done = subprocess.run(
        command("demo", "--speed", "60", "--seed", "1", "--out", str(tmp_path), "--json", "-"),
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
    )
    said = done.stderr
    assert done.returncode == 0, said
    result = json.loads(done.stdout)
    assert result["iterations_without_hull"] == 14
    assert result["iterations"] == len(result["mae_per_iteration"]["V1"]) == 25
    rows = repeat(1, whole=False).rows
    for served, regressor in zip(result["served"], ("IncSVR1", "IncSVR2"), strict=True):
        mae, _, vectors = rows[regressor, "paper", served["validation"]]
        # The learner on the bus is that of Table I; what it serves differs where it continues beyond its range, for the
        # better, by up to a twentieth.
        assert 0.92 * mae < served["mae"] < 1.02 * mae
        assert served["support_vectors"] == vectors
    act = result["underway"]
    assert act["truth"]["effect"] == "torque_saturation"
    assert act["right"]
    assert all(size["holds"] for size in act["sizes"])  # what other shapes of the effect make is in the interval
    assert [each["state"] for each in act["found"] if each["effect"] == "torque_saturation"] == ["proven"]
    steps = [step["step"] for step in act["history"] if step["effect"] == "torque_saturation"]
    assert steps == ["suspected", "proven"]
    assert act["served_effects"] == []
    ledgers = every(tmp_path / "leng.rrd", "TextDocument:text", "/effects/ledger")
    assert any("## Torque saturation (proven)" in ledger for ledger in ledgers)
    assert (
        said.index("The cover is mounted")
        < said.index("iteration 25, ")
        < said.index("Ground truth: torque_saturation")
    )
    assert not still_running(str(tmp_path))


@pytest.mark.parametrize(
    ("found", "judgement"),
    [
        ({"effect": "torque_saturation", "thrust_nm": [[100.0, 75.6, 71.2, 80.0]]}, "In part"),  # of another shape
        ({"effect": "torque_saturation", "thrust_nm": [[100.0, 69.9, 69.0, 71.0]]}, "Correct"),
        ({"effect": "dead_zone", "cannot_tell_from": ["torque_saturation"]}, "In part"),
        ({"effect": "dead_zone"}, "A different effect was found"),
    ],
)
def test_correct_is_what_gives_the_thrust(found: dict[str, Any], judgement: str) -> None:
    """The parameters of two shapes of a limit say nothing of each other: 98.8 N m of one is 72.9 N m of the other."""
    truth = {"effect": "torque_saturation", "since": 840.0, "parameters": {"limit_nm": 72.9}}
    truth |= {"thrust_nm": [[90.0, 66.66], [110.0, 69.76]]}
    step = {"t": 900.0, "step": "proven", "effect": found["effect"], "why": ""}
    ledger = EffectsLedger(found=({**found, "state": "proven", "sentence": "it saturates"},), history=(step,))
    said = " ".join(verdict(outcome(ledger, 800.0, 1, truth)))
    assert judgement in said
    assert "72.9" not in said
    assert ("thrust at 100 N m commanded: found" in said) == ("thrust_nm" in found)


@pytest.mark.slow
def test_ctrl_c_ends_the_demo_and_all_it_started(tmp_path: Path) -> None:
    process = subprocess.Popen(
        command("demo", "--speed", "1", "--out", str(tmp_path)), stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert process.stdout is not None
    with process:
        assert b"The cover is mounted" in process.stdout.readline()
        assert still_running(str(tmp_path))
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=PATIENCE)
    assert process.returncode == 1
    assert b"nothing is left running" in said
    assert not still_running(str(tmp_path))


def still_running(mark: str) -> list[str]:
    """Processes whose command line holds a mark of ours."""
    found = []
    for process in psutil.process_iter(["cmdline"]):
        words = " ".join(process.info["cmdline"] or ())
        if mark in words and process.pid != os.getpid():
            found.append(words)
    return found
