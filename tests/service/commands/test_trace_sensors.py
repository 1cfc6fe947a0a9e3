"""What `incsvr trace` makes of sensors that fail: refused, mended or remarked, never believed without a word."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from incsvr.numerics import Array
from service.cli.command_line import main
from service.fitting.sensors import examine_sensors, sensor_notes
from service.recordings.recording import from_table
from service.recordings.recording_csv import write
from tests.worlds import ROV, slow

STEP = 0.05
"""Between two rows [s]."""


def recording(stiffness: float = 0.0, seconds: float = 288.0) -> dict[str, Array]:
    """A vehicle of 24 kg m² driven by held commands, with a heading; a tether [N m/rad] turns it back."""
    rng = np.random.default_rng(11)
    t = np.asarray(np.arange(0.0, seconds, STEP), dtype=np.float64)
    command = np.repeat(rng.uniform(-15.0, 15.0, t.size // 120), 120)
    rate, heading = np.zeros(t.size), np.zeros(t.size)
    for k in range(t.size - 1):
        moment = command[k] - 9.0 * rate[k] - 26.0 * rate[k] * abs(rate[k]) - stiffness * heading[k]
        rate[k + 1] = rate[k] + STEP * moment / 24.0
        heading[k + 1] = heading[k] + STEP * rate[k]
    return {
        "t": t,
        "yaw_rate": rate + rng.normal(0.0, 0.002, t.size),
        "torque": command + rng.normal(0.0, 0.15, t.size),
        "heading": heading + rng.normal(0.0, 0.003, t.size),
    }


def saved(folder: Path, columns: dict[str, Array]) -> Path:
    path = folder / "run.csv"
    t = columns["t"]
    write(path, from_table("run.csv", t, {name: values for name, values in columns.items() if name != "t"}))
    return path


def traced(path: Path, capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    assert main(["trace", str(path), "--inertia", "24", "--json", "-"]) == 0
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


@pytest.mark.slow
def test_sound_sensors_are_not_spoken_of(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = traced(saved(tmp_path, recording()), capsys)
    assert found["verdict"] == "none"
    assert not [note for note in found["notes"] if note.startswith("run.csv")]


def test_a_gyro_stuck_for_half_a_minute_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    columns = recording()
    here = (columns["t"] >= 200.0) & (columns["t"] < 230.0)
    columns["yaw_rate"] = np.where(here, columns["yaw_rate"][np.argmax(here)], columns["yaw_rate"])
    assert main(["trace", str(saved(tmp_path, columns)), "--inertia", "24"]) == 2
    error = capsys.readouterr().err
    assert "run.csv: the yaw rate is constant" in error
    assert "leave these rows out" in error
    assert error.count("\n") == 1


@pytest.mark.slow
def test_a_clock_that_jumps_is_noted_with_its_instant(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    columns = recording(seconds=420.0)
    late = columns["torque"].copy()
    k, shift = round(220.0 / STEP), round(0.8 / STEP)
    late[k + shift :] = columns["torque"][k:-shift]
    late[k : k + shift] = np.nan
    found = traced(saved(tmp_path, columns | {"torque": late}), capsys)
    noted = next(note for note in found["notes"] if "late against the yaw rate since" in note)
    instant = float(noted.partition(" since ")[2].partition(" s")[0])
    assert instant == pytest.approx(220.0, abs=20.0)


def test_a_gyros_zero_is_noted_where_the_heading_contradicts_it() -> None:
    columns = recording()
    time = columns.pop("t")
    run = from_table("run.csv", time, columns | {"yaw_rate": columns["yaw_rate"] + 0.03})
    assert any(
        "rad/s more than the heading turns" in note for note in sensor_notes([run], examine_sensors([run], 24.0), False)
    )


@pytest.mark.slow
def test_a_compass_that_counts_clockwise_is_turned_and_noted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    columns = recording(stiffness=0.35)
    found = traced(saved(tmp_path, columns | {"heading": -columns["heading"]}), capsys)
    assert any("heading's sign was inverted" in note for note in found["notes"])
    tether = next(effect for effect in found["effects"] if effect["effect"] == "tether")
    assert tether["parameters"]["stiffness_nm_per_rad"] == pytest.approx(0.35, rel=0.05)


@pytest.mark.slow
def test_commands_that_come_too_slowly_are_told_beside_whatever_is_found() -> None:
    late, quick = slow(14, 0.5), slow(14, 0.05)
    sensors = examine_sensors([late, quick], ROV.inertia)
    (told,) = sensor_notes([late, quick], sensors, explained=False)
    assert told.startswith(f"{late.name}: the torque is sampled every 0.5 s")
    assert told.endswith("a trace that finds nothing proves nothing here: log the torque every 0.05 s")
