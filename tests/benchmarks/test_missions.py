"""The study of ordinary missions: its cases, its judges, and a small one made with the real learner and tracer."""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.tracer import mission_learner, mission_tracer
from benchmarks.tracer.mission_cases import HIDDEN, OTHER, USUAL, circumstance, hidden, quiet
from benchmarks.tracer.missions import add_arguments, cases, run
from incsvr.learning.model import Model
from simulator.missions import FULL_SIZE, KINDS, VEHICLES, Mission, Outcome, play


@pytest.fixture(scope="module")
def outcome() -> Outcome:
    return play(Mission("bursts", "auv", seed=1, duration=400.0))


def wanted(*options: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    return parser.parse_args(options)


def test_every_kind_vehicle_and_effect_is_tried_with_a_seed_of_its_own() -> None:
    missions = list(quiet(3, 0))
    assert {(mission.kind, mission.vehicle) for mission in missions} == {(k, v) for k in KINDS for v in VEHICLES}
    assert len({mission.seed for mission in missions}) == len(missions) == 3 * len(KINDS) * len(VEHICLES)
    assert {mission.effect for mission in missions} == {None}
    assert {circumstance(mission) for mission in missions} == {one.name for one in USUAL + OTHER}
    surveys = list(hidden("survey", "rov", 3, 0))
    assert set(FULL_SIZE) | {"heading_current"} == {mission.effect for mission in surveys}
    assert len({mission.seed for mission in surveys}) == len(surveys) == 3 * len(HIDDEN)
    both = cases(wanted("--first-seed", "0"))
    found = len({(case.group, case.mission.seed) for case in both})
    assert found == 2 * len(missions) + len(VEHICLES) * len(surveys) + (len(KINDS) - 3) * len(HIDDEN)


def test_a_choice_of_kinds_leaves_the_seeds_of_the_others_alone() -> None:
    some = list(quiet(2, 500, kinds=("transit",), vehicles=("rov",)))
    assert some == [mission for mission in quiet(2, 500) if (mission.kind, mission.vehicle) == ("transit", "rov")]


@pytest.mark.parametrize(
    ("effect", "named", "judged"),
    [
        (None, {}, "right"),
        (None, {"inflow": []}, "false"),
        ("drag_step", {"drag_drift": []}, "right"),
        ("drag_step", {"drag_drift": [], "drag_step": ["memory"]}, "right"),
        ("drag_drift", {"memory": ["drag_step"]}, "class"),
        ("dead_zone", {}, "missed"),
        ("dead_zone", {"inflow": []}, "both"),
        ("dead_zone", {"dead_zone": [], "inflow": []}, "false"),
    ],
)
def test_the_judge_of_effects(effect: str | None, named: dict[str, list[str]], judged: str) -> None:
    assert mission_tracer.verdict(effect, named) == judged


def test_the_error_of_a_parameter_is_in_parts_of_the_true_one() -> None:
    truth: dict[str, float | str] = {"delay_s": 0.25}
    assert mission_tracer.parameter_error("torque_delay", truth, {"torque_delay": {"delay_s": 0.2}}) == pytest.approx(
        0.2
    )
    assert mission_tracer.parameter_error("torque_delay", truth, {"torque_lag": {"time_constant_s": 0.2}}) is None


def fitted(outcome: Outcome, factor: float) -> Model:
    """A model whose curve is the truth times a factor, nearly."""
    gamma, rates = 40.0, np.linspace(-0.62, 0.62, 41)
    kernel = np.exp(-gamma * (rates[:, None] - rates) ** 2)
    damping = factor * outcome.damping(rates)
    weight = np.asarray(np.linalg.solve(kernel + 1e-9 * np.eye(rates.size), damping), np.float64)
    count = np.ones(rates.size, dtype=np.float64)
    return Model(gamma, 1e9, 0.1, rates, damping, weight, count, sigma=0.2, certified_error=0.0)


def test_the_judge_of_curves(outcome: Outcome) -> None:
    right, tenfold, turned = (mission_learner.judged(outcome, fitted(outcome, factor)) for factor in (1.0, 10.0, -1.0))
    assert right["near"] == 1.0
    assert right["drives"] == 0.0
    assert right["covered"] > 0.95
    np.testing.assert_allclose(right["ratios"], 1.0, atol=0.02)
    assert tenfold["near"] < 0.3
    assert tenfold["covered"] < 0.3
    assert turned["drives"] > 0.7


def test_the_tracer_is_judged_by_what_was_hidden(outcome: Outcome) -> None:
    biased = mission_tracer.examine("surveys", play(replace(outcome.mission, effect="bias_torque")))
    assert biased["judged"] == "right"
    assert biased["parameter_error"] < 0.3
    carried = mission_tracer.examine("quiet", play(replace(outcome.mission, kind="station")))
    assert carried["judged"] == "refused"
    text = mission_tracer.report_quiet([carried]) + mission_tracer.report_hidden([biased], by="kind")
    assert "| bias_torque | 1 | 1 |" in text
    assert carried["refused"] in mission_tracer.sentences([carried], "refused")


def test_a_small_study_of_the_learner(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = ("--only", "learner", "--runs", "1", "--kinds", "rate_control", "station", "--vehicles", "auv")
    assert run(wanted(*options, "--first-seed", "2000", "--processes", "1", "--out", str(tmp_path))) == 0
    document = json.loads((tmp_path / "missions_learner.json").read_text(encoding="utf-8"))
    assert [record["policy"] for record in document["records"]] == ["paper", "weighted"] * 2
    driven = [record for record in document["records"] if record["kind"] == "rate_control"]
    assert all(record["near"] > 0.8 for record in driven)
    text = (tmp_path / "missions_learner.md").read_text(encoding="utf-8")
    assert "| rate_control | auv | 1 |" in text
    assert document["command"] in text
    assert text.strip() in capsys.readouterr().out
