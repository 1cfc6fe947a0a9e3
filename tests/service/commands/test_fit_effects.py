"""`incsvr fit --effects`: the model of the learner on the bus, and free runs that hold the effects."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from incsvr.model.rows import Factor
from incsvr.numerics import Array
from service.cli.command_line import main
from service.config.sources import read as read_config
from service.config.traced_effects import configured_effects
from service.learner.node import LearnerNode
from service.recordings.recording_csv import write
from tests.hidden import acting, recording, with_channels, write_trace


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two runs of a vehicle with a hidden lag and a bent fin, and the trace of them."""
    folder = tmp_path_factory.mktemp("hidden")
    for seed in (1, 2):
        write(folder / f"{seed}.csv", recording(seed, 200.0))
    write_trace(folder / "trace.json")
    return folder


def fit(capsys: pytest.CaptureFixture[str], folder: Path, *words: str | Path) -> dict[str, Any]:
    declared = () if "--config" in words else ("--inertia", "350")
    common = ["fit", folder / "1.csv", "--validate", folder / "2.csv", *declared, *words, "--json", "-"]
    assert main([*map(str, common)]) == 0
    result: dict[str, Any] = json.loads(capsys.readouterr().out)
    return result


def test_the_error_and_the_free_run_are_those_of_the_noise(capsys: pytest.CaptureFixture[str], folder: Path) -> None:
    without = fit(capsys, folder)["validation"]
    with_effects = fit(capsys, folder, "--effects", folder / "trace.json")["validation"]
    assert with_effects["mae"] < 1.5 < 3.0 < without["mae"]
    assert with_effects["free_run_rmse"] < 0.004 < 0.01 < without["free_run_rmse"]  # the gyro's noise is 0.002 rad/s


def test_it_is_the_model_of_the_learner_on_the_bus(
    capsys: pytest.CaptureFixture[str], folder: Path, tmp_path: Path
) -> None:
    path = tmp_path / "config.yaml"
    path.write_text(f"state: null\nvehicle: {{inertia: 350}}\neffects: {folder / 'trace.json'}\n", encoding="utf-8")
    fitted = fit(capsys, folder, "--config", path)
    config = read_config(path)
    node = LearnerNode(config, "", effects=configured_effects(config))
    for name, (t, value) in recording(1, 200.0).streams().items():
        node.push(name, t, value)
    errors, snapshot = [], None
    while (outcome := node.learn()) is not None:
        errors.append(outcome.report.progressive_mae)
        snapshot = outcome.served
    assert snapshot is not None
    assert errors[0] is None
    assert fitted["progressive_mae"][1:] == pytest.approx(errors[1:], rel=1e-9)  # the learner's sums, the bus's curve
    assert tuple(fitted["trained_range"]) == snapshot.model.trained_range


def test_a_recording_without_the_channel_of_an_effect_is_refused(
    capsys: pytest.CaptureFixture[str], folder: Path, tmp_path: Path
) -> None:
    trace = json.loads((folder / "trace.json").read_text(encoding="utf-8"))
    trace["model"]["effects"].append(acting("coupling:sway", Factor("value", "sway"), value=-8.0).to_dict())
    (tmp_path / "sway.json").write_text(json.dumps(trace), encoding="utf-8")
    assert main(["fit", str(folder / "1.csv"), "--inertia", "350", "--effects", str(tmp_path / "sway.json")]) == 2
    assert "an effect reads the channel sway" in capsys.readouterr().err
    run = recording(1, 200.0)
    sway: Array = np.sin(0.3 * run.time)
    write(tmp_path / "1.csv", with_channels(run, {"sway": sway}))
    assert main(["fit", str(tmp_path / "1.csv"), "--inertia", "350", "--effects", str(tmp_path / "sway.json")]) == 0
