"""`incsvr fit` on motion that is quicker than its samples show: what it tried and found better is in force."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from service.cli.command_line import main
from service.config.sources import read
from service.recordings.recording import Recording
from service.recordings.recording_csv import write
from tests.worlds import slow


def quick(folder: Path, every: float, changes: tuple[float, float], noise: float) -> tuple[str, str]:
    """Two logs of a small vehicle, whose torque comes so often [s] and never repeats itself."""
    paths = []
    for seed in (4, 5):
        recording = slow(seed, every, changes, 300.0)
        time, torque = recording.streams()["torque"]
        torque = torque + noise * np.random.default_rng(seed).standard_normal(torque.size)
        path = folder / f"{seed}.csv"
        write(path, Recording(path.name, {**recording.streams(), "torque": (time, torque)}))
        paths.append(str(path))
    return paths[0], paths[1]


def fit(capsys: pytest.CaptureFixture[str], logs: tuple[str, str], *words: str) -> Any:
    assert main(["fit", logs[0], "--validate", logs[1], "--inertia", "0.6", *words, "--json", "-"]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize("seed", [30, 34, 38])
def test_the_few_samples_of_slow_motion_tell_that_the_filter_is_too_slow(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, seed: int
) -> None:
    """A log of 290 samples has 25 slow ones, half of which swing; `fit` found N_r = 1.7 (0.9 to 2.5) for 0.6 in it."""
    write(tmp_path / "run.csv", slow(seed, 0.05, duration=30.0))
    assert main(["fit", str(tmp_path / "run.csv"), "--inertia", "0.6", "--json", "-"]) == 0
    linear = json.loads(capsys.readouterr().out)["coefficients"]["N_r"]
    assert linear["low"] <= 0.6 <= linear["high"] < 1.2


@pytest.mark.slow
@pytest.mark.parametrize(
    ("setting", "every", "changes", "noise", "person", "used"),
    [
        ("smoothing", 0.05, (0.3, 0.9), 0.05, 0.2, "s is used, because 0.2 s is too slow"),
        ("torque", 0.2, (0.8, 2.4), 1e-6, "measured", "the torque is used as a command"),
    ],
)
def test_what_was_tried_and_is_better_is_in_force_unless_a_person_set_another(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    setting: str,
    every: float,
    changes: tuple[float, float],
    noise: float,
    person: Any,
    used: str,
) -> None:
    logs, written = quick(tmp_path, every, changes, noise), tmp_path / "config.yaml"
    found = fit(capsys, logs, "--write", str(written), "--state", str(tmp_path))
    chosen = found["settings"]["signals"][setting]
    assert chosen != person
    assert any(used in remark for remark in found["remarks"])
    assert not any("; give --" in remark for remark in found["remarks"])
    assert getattr(read(written).signals, setting) == chosen
    fixed = {"smoothing": 0.2} if setting == "smoothing" else {"torque": "measured", "smoothing": 0.6}
    stays = fit(capsys, logs, *(word for key, value in fixed.items() for word in ("--set", f"signals.{key}={value}")))
    assert stays["settings"]["signals"][setting] == person
    assert any(f"; give --set signals.{setting}=" in remark for remark in stays["remarks"])
    assert found["validation"]["free_run_rmse"] < 0.97 * stays["validation"]["free_run_rmse"]
    written.write_text(f"signals: {{smoothing: {0.2 if setting == 'smoothing' else 0.6}, torque: measured}}\n")
    assert fit(capsys, logs, "--config", str(written))["settings"]["signals"][setting] == person
