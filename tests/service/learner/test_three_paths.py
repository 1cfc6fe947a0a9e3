"""`fit`, `fit --config` of what it wrote, and `serve` judge the same sound data alike, and put none of it aside."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from incsvr.numerics import Array
from service import wire
from service.cli.command_line import main
from service.config.sources import read
from service.learner.node import LearnerNode
from service.recordings.reading import read as read_csv
from service.recordings.recording import Recording
from service.recordings.recording_csv import write
from tests.service.conftest import PATIENCE, StartBench

STEP_S = 0.01
"""Step of the integration [s]."""
RELAY_RAD = 0.2
"""Error of the heading at which a relay switches [rad]."""
PIECE_S = 1.0
"""A live learner gets its messages in pieces of so long [s]."""


@dataclass(frozen=True)
class Plant:
    """A vehicle I ṙ = τ − a r − b r|r|, the torque it is driven by [N m], how long a step lasts [s], the gyro's noise
    [rad/s]."""

    inertia: float
    linear: float
    quadratic: float
    torque: float
    lasts: tuple[float, float]
    noise: float


PLANTS = {
    "leng": Plant(350.0, 100.0, 1400.0, 110.0, (4.0, 10.0), 0.003),
    "rov": Plant(0.6, 0.6, 1.6, 6.0, (2.0, 5.0), 0.01),
    "small": Plant(12.0, 6.0, 9.0, 10.0, (3.0, 8.0), 0.005),
    "large": Plant(4000.0, 600.0, 5000.0, 600.0, (8.0, 20.0), 0.001),
}
CASES = (
    ("steps", "leng", 5.0, 0), ("steps", "leng", 50.0, 1), ("steps", "leng", 20.0, 2),
    ("steps", "rov", 10.0, 1), ("steps", "rov", 50.0, 2), ("steps", "rov", 20.0, 3),
    ("steps", "small", 5.0, 2), ("steps", "small", 10.0, 3), ("steps", "small", 50.0, 4),
    ("steps", "large", 20.0, 3), ("steps", "large", 5.0, 4), ("steps", "large", 10.0, 0),
    ("reversals", "rov", 10.0, 7), ("reversals", "large", 50.0, 7),
    ("limit cycle", "leng", 10.0, 7), ("limit cycle", "rov", 50.0, 7),
    ("disarmed", "small", 10.0, 7), ("disarmed", "large", 50.0, 7),
)  # fmt: skip
"""Kind of torque, vehicle, rate of the log [Hz], seed: steps of each vehicle at three rates and three seeds, of each
rate with three vehicles. The filter of a log at 5 Hz is twice as slow as the rov: `fit` says so."""


def commands(kind: str, plant: Plant, rng: np.random.Generator, t: Array) -> Array:
    """(n,) torque [N m] at the times (n,) of an open loop."""
    edges = np.cumsum(rng.uniform(*plant.lasts, t.size))
    number = np.searchsorted(edges, t)
    level = rng.uniform(-1.0, 1.0, t.size)
    if kind == "reversals":
        level = np.where(np.arange(t.size) % 2, 1.0, -1.0) * rng.uniform(0.3, 1.0, t.size)
    torque = plant.torque * level[number]
    return np.where((kind == "disarmed") & (t // 60.0 % 3.0 == 2.0), 0.0, torque)


def sailed(path: Path, name: str, kind: str, seed: int, hertz: float, seconds: float) -> Path:
    """A recording of a vehicle whose torque is a command, constant between its steps."""
    plant, rng = PLANTS[name], np.random.default_rng([seed, list(PLANTS).index(name)])
    t = STEP_S * np.arange(round(seconds / STEP_S), dtype=np.float64)
    torque, rates = commands(kind, plant, rng, t), np.empty(t.size)
    rate = heading = 0.0
    side = 0.5
    for k in range(t.size):
        if kind == "limit cycle":  # a relay holds a heading
            error = np.sin(t[k] / 30.0) - heading
            side = np.copysign(side, error) if abs(error) > RELAY_RAD else side
            torque[k] = plant.torque * side
        rates[k] = rate
        rate += STEP_S * (torque[k] - plant.linear * rate - plant.quadratic * rate * abs(rate)) / plant.inertia
        heading += STEP_S * rate
    gyro, command = (t[:: round(1.0 / (STEP_S * each))] for each in (hertz, min(hertz, 25.0)))
    measured = np.interp(gyro, t, rates) + rng.normal(0.0, plant.noise, gyro.size)
    sent = torque[:: round(1.0 / (STEP_S * min(hertz, 25.0)))]
    write(path, Recording(path.name, {"yaw_rate": (gyro, measured), "torque": (command, sent)}))
    return path


def fit(*words: str | Path) -> dict[str, Any]:
    result = Path(words[0]).parent / "fit.json"
    assert main(["fit", *map(str, words), "--json", str(result)]) == 0
    found: dict[str, Any] = json.loads(result.read_text(encoding="utf-8"))
    return found


def served(path: Path, config: Path) -> tuple[int, list[str]]:
    """How many batches a learner of this configuration has learned of a recording, and why it paused."""
    node, streams = LearnerNode(read(config), boot=""), read_csv(path).streams()
    paused: list[str] = []
    for first in np.arange(0.0, max(float(t[-1]) for t, _ in streams.values()) + PIECE_S, PIECE_S).tolist():
        for name in streams.keys() & {"yaw_rate", "torque", "heading"}:
            t, value = streams[name]
            part = (t >= first) & (t < first + PIECE_S)
            if part.any() and node.push(name, t[part], value[part]):
                while node.learn() is not None:
                    pass
                paused += [node.current_warnings.paused] if node.current_warnings.paused else []
    return node.memory()["learner"]["iterations"], paused


def learned_by_all(path: Path, folder: Path, inertia: float) -> tuple[int, Path]:
    """How many batches all three learn, and what `fit` wrote: none is put aside, no sensor is blamed."""
    config = folder / "written.yaml"
    first = fit(path, "--inertia", str(inertia), "--write", config, "--state", folder / "state", "--force")
    again = fit(path, "--config", config)
    count, paused = served(path, config)
    for found in (first, again):
        assert found["put_aside"] == 0, found["remarks"]
        assert found["iterations"] == found["samples"] // found["settings"]["learner"]["batch"]
        assert not any("check the sensor" in remark for remark in found["remarks"])
    assert not paused
    assert again["iterations"] == count
    return count, config


def test_clean_steps_are_learned_whole(tmp_path: Path) -> None:
    assert learned_by_all(sailed(tmp_path / "steps.csv", "leng", "reversals", 0, 50.0, 200.0), tmp_path, 350.0)[0] >= 5


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "name", "hertz", "seed"), CASES)
def test_torques_that_rest_between_steps(kind: str, name: str, hertz: float, seed: int, tmp_path: Path) -> None:
    path = sailed(tmp_path / "run.csv", name, kind, seed, hertz, 240.0)
    learned_by_all(path, tmp_path, PLANTS[name].inertia)


MEASURED = {f"bluerov/run_{k:02d}": 1.125 for k in (3, 4, 5, 6, 7, 8, 9, 10, 12, 13, 14, 15)} | {
    f"kvlcc2/Z_{name}": 16_100.0 for name in ("05_01", "10_05", "10_10_P", "15_05", "20_10_S", "25_05", "35_05")
}


@pytest.mark.slow
@pytest.mark.parametrize("name", MEASURED)
def test_measured_recordings(name: str, measured: Path, tmp_path: Path) -> None:
    recording = tmp_path / "run.csv"
    recording.write_bytes((measured / f"{name}.csv").read_bytes())
    learned_by_all(recording, tmp_path, MEASURED[name])


@pytest.mark.slow
def test_the_same_over_a_real_bus(start: StartBench, tmp_path: Path) -> None:
    path = sailed(tmp_path / "steps.csv", "small", "reversals", 3, 50.0, 200.0)
    count, config = learned_by_all(path, tmp_path, PLANTS["small"].inertia)
    written = yaml.safe_load(config.read_text(encoding="utf-8"))
    sections = {part: values for part, values in written.items() if isinstance(values, dict)}
    settings = {f"{part}__{key}": value for part, values in sections.items() for key, value in values.items()}
    bench = start(**settings)
    models = bench.follow(bench.keys.model, wire.ModelSnapshot)
    bench.play(read_csv(path))
    while models.get(timeout=PATIENCE).iteration < count:
        pass
    assert bench.health().learning.state != "paused"
