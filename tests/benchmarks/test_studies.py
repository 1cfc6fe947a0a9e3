"""A small run of each study, with real learners, processes, libraries and recordings."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks import dives, hold, paper, peers, quiet, sensors, speed, thrust, vehicles
from benchmarks.peers import Signals
from benchmarks.study import MEASURED
from incsvr.numerics import Array
from service.recordings.recording import Recording
from simulator import leng

Study = Callable[..., list[dict[str, Any]]]


@pytest.fixture
def study(tmp_path: Path) -> Study:
    """Runs a study's `main`; gives its results."""

    def ran(main: Callable[[Sequence[str]], None], *words: str) -> list[dict[str, Any]]:
        main([*words, "--out", str(tmp_path)])
        (document,) = (json.loads(path.read_text(encoding="utf-8")) for path in tmp_path.glob("*.json"))
        results: list[dict[str, Any]] = document["results"]
        return results

    return ran


def test_the_weighted_policy_is_nearer_to_the_truth_than_the_papers(
    study: Study, capsys: pytest.CaptureFixture[str]
) -> None:
    (hull,) = study(paper.main, "--seeds", "1", "--first-seed", "11", "--only", "hull")
    assert hull["weighted"]["since"] < hull["paper"]["since"]
    assert hull["baselines"]["least squares"] < 3.0  # linear + quadratic is what the hull leaves of the damping
    assert all(0.8 < hull[policy][of] <= 1.0 for policy in paper.SETTINGS for of in ("truth", "samples"))
    assert "| hull: the hull adds 11.5 % |" in capsys.readouterr().out


@pytest.mark.slow
def test_a_frozen_gyro_is_named_and_a_sound_hour_is_not_paused(study: Study, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sensors, "FAULT_LASTS_S", 120.0)
    monkeypatch.setattr(sensors, "AFTERWARDS_S", 60.0)
    monkeypatch.setattr(sensors, "cases", lambda asked: [
        ("gyro frozen", True, False, 7, "weighted", 0.0), ("nothing", False, True, 8, "weighted", 0.2)])  # fmt: skip
    frozen, sound = study(sensors.main)
    assert frozen["right"]
    assert "yaw_rate stuck" in frozen["kinds"]
    assert frozen["named_after"] < 60.0
    assert sound["false"] == 0


def test_a_held_commands_clock_is_not_blamed_for_the_jitter_of_its_stamps(study: Study) -> None:
    found = study(quiet.main, "--first-seed", "101", "--seeds", "1", "--only", "disarmed")
    assert [each["said"] for each in found] == [[], [], []]
    assert all(each["batches"] > 20 for each in found)


@pytest.mark.parametrize("stream", ["torque", "yaw_rate"])
def test_a_held_commands_clock_that_runs_fast_is_named(stream: str) -> None:
    streams = quiet.recording_of(("steps of 4–10 s", "leng", 7)).streams()
    begins, (time, value) = 300.0, streams[stream]
    streams[stream] = (time + 0.005 * np.maximum(time - begins, 0.0), value)
    verdicts = quiet.verdicts_on(Recording("fast", streams), leng.INERTIA)
    assert all(verdict.learn for verdict in verdicts if verdict.span[1] < begins)
    first = next(verdict for verdict in verdicts if verdict.span[0] > begins)
    assert not first.learn
    assert f"{stream} pace" in {finding.kind for finding in first.findings}


@pytest.mark.slow
def test_half_the_thrust_lost_in_a_mission_is_told(study: Study) -> None:
    groups: list[Any] = study(
        thrust.main, "--first-seed", "3500003", "--faults", "1", "--quiet", "0", "--measured", "0"
    )
    ((told,),) = groups
    assert told["driven"] <= told["told"] <= 60.0
    assert abs(told["size"] - told["lost"]) < 0.1
    assert told["false"] == []


@pytest.mark.slow
def test_a_drag_that_doubles_is_found_in_its_dive(study: Study) -> None:
    words = ("--changed", "1", "--quiet", "1", "--seconds", "60", "--factor", "2", "--fleet", "10", "--history", "20")
    *drawn, fleet = study(dives.main, *words)
    for kind in ("torpedo", "boat"):
        changed, quiet = (each for each in drawn if each["kind"] == kind)
        assert [2, changed["axis"], "drag"] in changed["reported"]
        assert quiet["reported"] == []
    assert ["changed drags found", "1 of 1 (21–100 %)"] in fleet["rows"]


@pytest.mark.slow
def test_a_learner_survives_kills_and_junk(study: Study, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hold, "TRIES", {name: hold.TRIES[name] for name in ("kills", "junk")})
    kills, junk = study(hold.main, "--part", "0.005")
    assert (kills["tried"], junk["tried"]) == (1, 50)
    assert [each["wrong"] for each in (kills, junk)] == [0, 0]
    assert kills["lost"] == junk["lost"] == 0


@pytest.mark.slow
def test_a_fleet_arrives_ashore_and_six_axes_are_learned_in_one_process(
    study: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(speed, "SETTLE_S", 1.0)
    words = ("--vehicles", "2", "--pace", "200", "--seconds", "4")
    fleet, six = (dict(each["rows"]) for each in study(speed.main, *words))
    assert fleet["history fetched through the router"].startswith("28 iterations")
    assert six["messages lost / values rejected"] == "0 / 0"


STEP, COUNT = 0.1, 1200


@pytest.fixture(scope="module")
def driven() -> Signals:
    """ṙ = 0.5 τ − 0.8 r − 0.6 u v with steps of τ that hold, two runs of it."""
    random = np.random.default_rng(900_100)
    torque = np.repeat(random.uniform(-1.0, 1.0, COUNT // 12), 12)
    time: Array = STEP * np.arange(COUNT, dtype=np.float64)
    surge, sway = np.sin(0.3 * time) + 0.4 * np.sin(1.1 * time), np.cos(0.47 * time)
    rate, kept = np.zeros(COUNT), np.exp(-0.8 * STEP)
    for k in range(COUNT - 1):
        rate[k + 1] = kept * rate[k] + (1.0 - kept) / 0.8 * (0.5 * torque[k] - 0.6 * surge[k] * sway[k])
    start = np.array([0, COUNT // 2, COUNT], dtype=np.intp)
    return Signals(STEP, start, rate, torque, {"surge": surge, "sway": sway}, scale=1.5)


def test_the_libraries_find_the_product_of_two_velocities(driven: Signals, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(peers, "THRESHOLDS", (0.03, 0.1))
    monkeypatch.setattr(peers, "TERMS", (4, 6))
    for learn in (peers.sindy, peers.frols):
        simulated = learn(driven, ("surge", "sway")).simulate(driven)
        assert np.sqrt(np.mean((simulated - driven.rate) ** 2)) < 0.1 * np.std(driven.rate)


def test_no_recording_is_fitted_and_judged_on() -> None:
    for _, _, _, fitted, unseen in vehicles.SPLITS:
        assert not set(fitted) & set(unseen)


@pytest.mark.slow
def test_a_measured_split_runs_end_to_end(study: Study, monkeypatch: pytest.MonkeyPatch) -> None:
    if not (MEASURED / "dagon").is_dir():
        pytest.skip("the measured recordings are not in ../shared/measured")
    monkeypatch.setattr(peers, "THRESHOLDS", (0.1,))
    monkeypatch.setattr(peers, "TERMS", (4,))
    monkeypatch.setattr(peers, "MOST_SAMPLES", 100)
    monkeypatch.setattr(vehicles, "SPLITS", (("dagon", "sway", 2500.0, ["run_05"], ["run_07"]),))
    (record,) = study(vehicles.main)
    assert set(record["errors"]) == set(vehicles.METHODS)
    assert "the axis is coupled to others" in record["failed"]["incsvr fit"]
    assert record["trace"]["after"] < record["trace"]["before"]
