"""The tracer on vehicles whose simulator shares nothing with it, on measured ones, and on input that cannot answer."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.tracing.result import trace
from incsvr.tracing.run import Run
from service.recordings.reading import read
from service.recordings.recording import Recording
from simulator.mission import Mission
from simulator.sensors import GYRO_NOISE, Sensor, schedule
from simulator.vehicles import TURNING
from simulator.world import play
from tests.worlds import as_run

PUBLISHED = 1.125
"""Moment of inertia of the measured ROV, as published [kg m²]."""


def sine(seconds: float = 300.0) -> Run:
    """A plain vehicle under a sine, without noise to speak of."""
    time = np.asarray(np.arange(0.0, seconds, 0.05), dtype=np.float64)
    rate = np.asarray(0.2 * np.sin(2 * np.pi * time / 40.0), dtype=np.float64)
    torque = 350.0 * np.gradient(rate, 0.05) + 100.0 * rate + 800.0 * rate * np.abs(rate)
    noise = np.random.default_rng(3).normal(0.0, 1.0, time.size)
    return Run("sine", time, rate, torque + noise)


@pytest.mark.parametrize(
    ("spoil", "cure"),
    [
        (lambda run: replace(run, time=run.time * 1000.0), "divide t by 1000"),
        (lambda run: replace(run, yaw_rate=run.yaw_rate * 180.0 / math.pi), "convert degrees"),
        (lambda run: replace(run, torque=np.full(run.time.size, np.nan)), "torque holds no numbers"),
        (lambda run: replace(run, yaw_rate=np.zeros(run.time.size)), "never changes"),
        (lambda run: replace(run, time=run.time[::-1]), "t must increase"),
        (lambda run: replace(run, yaw_rate=run.yaw_rate[:-1]), "different lengths"),
        (lambda run: replace(run, channels={"heading": np.degrees(np.cumsum(run.yaw_rate) * 0.05)}), "to rad"),
    ],
)
def test_bad_input_gets_one_sentence_with_its_cure(spoil, cure: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(BadInput, match=cure):
        trace([spoil(sine())], inertia=350.0)


def test_too_short_a_recording_is_refused_not_called_empty() -> None:
    with pytest.raises(BadInput, match="too few"):
        trace([sine(9.0)], inertia=350.0)


@pytest.mark.slow
def test_channels_that_say_nothing_are_named() -> None:
    run = sine(400.0)
    sway = np.sin(run.time / 7.0)
    channels = {
        "dead": np.full(run.time.size, 3.0),
        "empty": np.full(run.time.size, np.nan),
        "sway": sway,
        "sway_again": 2.0 * sway + 1.0,
        "command": 0.01 * run.torque,
    }
    ignored = trace([replace(run, channels=channels)], inertia=350.0).ignored_channels
    assert set(ignored) == {"dead", "empty", "sway_again", "command"}
    assert "constant" in ignored["dead"]
    assert ignored["empty"] == "it is empty"
    assert "copy of sway" in ignored["sway_again"]
    assert "torque" in ignored["command"]


@pytest.mark.slow
def test_where_the_controller_has_another_gyro_nothing_is_sought_and_that_is_said() -> None:
    """A survey whose log holds another gyro than the controller's, with nothing hidden."""
    outcome = play(Mission(TURNING["auv"], "survey", 5, duration=600.0))
    commands, other = outcome.recording.streams()["torque"], Sensor("yaw_rate", 10.0, GYRO_NOISE, phase=0.4)
    samples = schedule(other, 600.0, np.random.default_rng(5))
    rate = np.interp(samples.at, outcome.time, outcome.true("yaw_rate")) + samples.error
    log = Recording("survey", {"yaw_rate": (samples.stamps, rate), "torque": commands})
    run = Run("survey", log.time, log.columns["yaw_rate"], log.columns["torque"])
    found = trace([run], inertia=outcome.inertia)
    assert found.effects == ()
    assert found.verdict == "unexplained"
    assert any("the controller reads another gyro" in note for note in found.notes)


def rov(measured: Path, *numbers: int) -> list[Run]:
    return [as_run(read(measured / "bluerov" / f"run_{number:02d}.csv")) for number in numbers]


@pytest.mark.slow
@pytest.mark.parametrize(("fitted", "unseen", "reached"), [((3,), 4, 0.85), ((3, 4), 5, 0.92)])
def test_measured_open_loop(fitted: tuple[int, ...], unseen: int, reached: float, measured: Path) -> None:
    """Inertia and the late thrust of a real vehicle, proven on the run that was not fitted."""
    found = trace(rov(measured, *fitted), inertia=PUBLISHED, validate=rov(measured, unseen))
    values = {finding.effect: finding.parameters for finding in found.effects}
    assert 0.55 < values["inertia"]["inertia_kg_m2"] < 0.75
    assert 0.05 < values["torque_lag"]["time_constant_s"] < 0.09
    assert found.proven
    error = found.error
    assert error["after"]["free_run_rmse"] < reached * error["before"]["free_run_rmse"]
    assert error["change"]["free_run_rmse"]["high"] < 0.0


@pytest.mark.slow
def test_of_a_short_lag_and_a_short_delay_one_is_named(measured: Path) -> None:
    """These runs tell little which it is; both together would say it twice."""
    found = trace(rov(measured, 3, 5), inertia=PUBLISHED, validate=rov(measured, 4))
    (late,) = found.effects
    assert late.effect in ("torque_delay", "torque_lag")
    assert 0.02 < next(iter(late.parameters.values())) < 0.08
    assert found.error["after"]["free_run_rmse"] < found.error["before"]["free_run_rmse"]
