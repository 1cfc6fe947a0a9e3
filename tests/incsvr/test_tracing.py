"""The tracer on vehicles whose simulator shares nothing with it, on measured ones, and on input that cannot answer."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from incsvr.errors import BadInput
from incsvr.model_trace.findings import Trace
from incsvr.model_trace.model import TracedModel
from incsvr.model_trace.result import trace, trace_if_found
from incsvr.model_trace.run import Run
from incsvr.model_trace.sentences import headline
from service.recordings.recording import from_streams
from service.recordings.recording_csv import read
from simulator.mission import Mission
from simulator.sensors import GYRO_NOISE, Sensor, schedule
from simulator.vehicles import TURNING
from simulator.world import Outcome, play, play_together
from tests.worlds import as_run, of_trial, trial

PUBLISHED = 1.125
"""Moment of inertia of the measured ROV, as published [kg m²]."""


@cache
def played() -> dict[tuple[tuple[str, ...], int], Outcome]:
    """By hidden effects and seed: Leng under many sines, all side by side."""
    hidden = ("torque_lag", "bias_torque", "heading_current", "inertia")
    cases = [*(((name,), 11) for name in hidden), ((), 11), ((), 12)]
    outcomes = play_together([of_trial(seed, effects, kind="multisine") for effects, seed in cases])
    return dict(zip(cases, outcomes, strict=True))


@cache
def traced(*effects: str, seed: int = 11) -> Trace:
    outcome = played()[effects, seed]
    return trace([as_run(outcome.recording)], inertia=outcome.inertia)


@pytest.mark.parametrize(
    "effect",
    ["torque_lag", *(pytest.param(name, marks=pytest.mark.slow) for name in ("bias_torque", "heading_current"))],
)
def test_names_what_is_hidden_and_proves_it(effect: str) -> None:
    found = traced(effect)
    assert [finding.effect for finding in found.effects] == [effect]
    finding = found.effects[0]
    assert finding.p_value < 1e-3
    assert finding.share > 0.5
    change = found.error["change"]["free_run_rmse"]
    assert change["low"] <= change["estimate"] <= change["high"] < 0.0
    assert found.error["after"]["torque_rmse"] < found.error["before"]["torque_rmse"]


@pytest.mark.parametrize("effects", [("torque_lag",), ()])
def test_a_trace_that_is_asked_for_effects_alone_is_the_same_or_none(effects: tuple[str, ...]) -> None:
    whole, outcome = traced(*effects), played()[effects, 11]
    found = trace_if_found([as_run(outcome.recording)], inertia=outcome.inertia)
    assert (None if found is None else found.to_dict()) == (whole.to_dict() if whole.effects else None)
    assert (found is None) == (not effects)


def test_names_nothing_where_nothing_is_hidden() -> None:
    found = traced(seed=12)
    assert found.verdict == "none"
    assert found.effects == ()
    assert found.error["after"] == found.error["before"]


def test_says_what_no_yaw_recording_can_tell_apart() -> None:
    found = traced("inertia")
    names = {finding.effect: finding for finding in found.effects}
    assert "inertia" in names
    assert "thrust_efficiency" in names["inertia"].cannot_tell_from
    assert "no manoeuvre in yaw" in names["inertia"].next_manoeuvre


def test_the_json_keeps_the_contract() -> None:
    plain = json.loads(json.dumps(traced("torque_lag").to_dict(), allow_nan=False))
    assert {"declared", "verdict", "effects", "rejected", "unexplained", "error"} <= set(plain)
    assert plain["verdict"] == "effects"
    keys = {"effect", "channels", "parameters", "interval", "p_value", "share", "cannot_tell_from", "next_manoeuvre"}
    for finding in plain["effects"]:
        assert keys | {"sentence"} <= set(finding)
        assert set(finding["interval"]) == set(finding["parameters"])
        for name, (low, high) in finding["interval"].items():
            assert low <= finding["parameters"][name] <= high
    for side in ("before", "after"):
        assert set(plain["error"][side]) == {"torque_mae", "torque_rmse", "free_run_rmse"}
    assert plain["error"]["floor"]["torque_rmse"] > 0.0
    assert plain["error"]["validated_on"] == "blocks"


def test_the_model_with_effects_is_one_value() -> None:
    """It survives JSON to the last bit, and its ledger splits every prediction into parts that add up."""
    found = traced("torque_lag")
    again = TracedModel.from_dict(json.loads(json.dumps(found.model.to_dict())))
    np.testing.assert_array_equal(again.damping, found.model.damping)
    assert again.effects == found.model.effects
    parts = found.pictures.ledger
    assert list(parts) == ["declared inertia", "damping", "torque_lag"]
    assert all(part.shape == found.pictures.ledger_time.shape for part in parts.values())


@pytest.mark.slow
def test_a_validation_recording_is_where_the_proof_happens() -> None:
    outcome = trial(21, ("bias_torque",), kind="multisine")
    other = trial(21, ("bias_torque",), kind="steps", duration=240.0)
    found = trace([as_run(outcome.recording)], inertia=outcome.inertia, validate=[as_run(other.recording)])
    assert found.error["validated_on"] == "recordings"
    assert sum(t.size for t in found.pictures.after.time) > 50


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
def test_what_no_effect_explains_is_named_and_gains_nothing() -> None:
    """A moment that is even in a channel: nobody's catalogue has it, and it must not be called an effect."""
    random = np.random.default_rng(8)
    time = np.asarray(np.arange(0.0, 300.0, 0.05), dtype=np.float64)
    torque = 60.0 * np.sin(2 * np.pi * time / 31.0) + 35.0 * np.sin(2 * np.pi * time / 11.0)
    arm = gaussian_filter1d(random.normal(size=time.size), 80.0, mode="wrap")
    arm = np.asarray(arm / np.std(arm), dtype=np.float64)
    rate = np.zeros(time.size)
    for k in range(time.size - 1):
        drag = 120.0 * rate[k] + 700.0 * rate[k] * abs(rate[k])
        rate[k + 1] = rate[k] + 0.05 * (torque[k] + 20.0 * (np.cos(1.5 * arm[k]) - 0.3) - drag) / 350.0
    run = Run("arm", time, rate + random.normal(0.0, 2e-4, time.size), torque + random.normal(0.0, 2.0, time.size))
    found = trace([replace(run, channels={"arm": arm})], inertia=350.0)
    assert "arm" in [item.channel for item in found.unexplained]
    assert found.verdict == "unexplained"
    assert found.effects == ()
    assert found.error["after"] == found.error["before"]
    assert headline(found) == "no known effect explains how the residual follows arm"


@pytest.mark.slow
def test_where_the_controller_has_another_gyro_nothing_is_sought_and_that_is_said() -> None:
    """A survey whose log holds another gyro than the controller's, with nothing hidden."""
    outcome = play(Mission(TURNING["auv"], "survey", 5, duration=600.0))
    commands, other = outcome.recording.streams()["torque"], Sensor("yaw_rate", 10.0, GYRO_NOISE, phase=0.4)
    samples = schedule(other, 600.0, np.random.default_rng(5))
    rate = np.interp(samples.at, outcome.time, outcome.true("yaw_rate")) + samples.error
    log = from_streams("survey", {"yaw_rate": (samples.stamps, rate), "torque": commands})
    run = Run("survey", log.time, log.columns["yaw_rate"], log.columns["torque"])
    found = trace([run], inertia=outcome.inertia)
    assert found.effects == ()
    assert found.verdict == "unexplained"
    assert any("the controller reads another gyro" in note for note in found.notes)


def rov(measured: Path, *numbers: int) -> list[Run]:
    return [as_run(read(measured / "bluerov" / f"run_{number:02d}.csv")) for number in numbers]


@pytest.mark.slow
def test_measured_open_loop(measured: Path) -> None:
    """Inertia and the late thrust of a real vehicle, proven on the run that was not fitted."""
    found = trace(rov(measured, 3, 5), inertia=PUBLISHED, validate=rov(measured, 4))
    values = {finding.effect: finding.parameters for finding in found.effects}
    assert 0.6 < values.pop("inertia")["inertia_kg_m2"] < 1.0
    (late,) = values  # of a short lag and a short delay the recordings tell little
    assert late in ("torque_delay", "torque_lag")
    assert 0.03 < next(iter(values[late].values())) < 0.08
    error = found.error
    assert error["after"]["free_run_rmse"] < 0.85 * error["before"]["free_run_rmse"]
    assert error["change"]["free_run_rmse"]["high"] < 0.0
