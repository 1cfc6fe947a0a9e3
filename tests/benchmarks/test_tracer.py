"""The tracer's studies: their judges, their cases, and a small run of each with the real tracer."""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from benchmarks.tracer import (
    bets_level,
    live_missions,
    mission_learner,
    mission_tracer,
    missions,
    second_cases,
    second_table,
    trace_table,
    trouble,
)
from benchmarks.tracer.judge import judge
from benchmarks.tracer.mission_cases import HIDDEN, OTHER_LOGS, USUAL_LOGS, circumstance, hidden, quiet
from benchmarks.tracer.trace_cases import AUTOCORRELATIONS, GROUPS, KINDS, case
from incsvr.learning.model import Model
from simulator.missions import FULL_SIZE, VEHICLES, Mission, Outcome, play
from simulator.missions import KINDS as MISSIONS
from simulator.trial import Trial
from simulator.trial_command import EXCITATIONS
from simulator.trial_effects import EFFECTS


@pytest.fixture(scope="module")
def outcome() -> Outcome:
    return play(Mission("bursts", "auv", seed=1, duration=400.0))


@pytest.mark.parametrize(
    ("sought", "named", "verdict"),
    [
        ((), {}, "right"),
        ((), {"inflow": ()}, "false"),
        (("wave",), {"wave": ("tether",)}, "right"),
        (("wave",), {}, "missed"),
        (("wave",), {"tether": ()}, "both"),
        (("torque_lag",), {"torque_delay": ("torque_lag",)}, "class"),
        (("torque_lag",), {"torque_lag": (), "torque_delay": ("torque_lag",)}, "false"),
        (("torque_lag", "wave"), {"torque_delay": ("torque_lag",)}, "missed"),
        (("torque_lag", "wave"), {"wave": (), "torque_delay": ("torque_lag",)}, "class"),
        # One named effect cannot stand for two hidden ones, nor beside itself for another, but as both at once.
        (("drag_step", "drag_drift"), {"memory": ("drag_step", "drag_drift")}, "joint"),
        (("drag_step", "wave"), {"wave": ("drag_step",)}, "joint"),
        (("drag_step", "wave"), {"wave": ("drag_step",), "tether": ()}, "false"),
        (("coupling:sway",), {"coupling:surge": ()}, "both"),
    ],
)
def test_the_judge(sought: tuple[str, ...], named: dict[str, tuple[str, ...]], verdict: str) -> None:
    assert judge(sought, named) == verdict


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
def test_two_forms_of_one_effect_count_as_one(effect: str | None, named: dict[str, list[str]], judged: str) -> None:
    assert mission_tracer.verdict(effect, named) == judged


@pytest.mark.parametrize(
    ("truth", "record", "verdict"),
    [
        ("gyro_bias", {"named": {"gyro_bias": []}, "verdict": "effects", "said": []}, "right"),
        ("gyro_bias", {"named": {"bias_torque": ["gyro_bias"]}, "verdict": "effects", "said": []}, "class"),
        ("gyro_bias", {"named": {"gyro_bias": [], "inertia": []}, "verdict": "effects", "said": []}, "false"),
        ("", {"named": {"inertia": []}, "verdict": "effects", "said": ["the gyro is stuck"]}, "said"),
        ("", {"named": {}, "verdict": "unexplained", "said": []}, "said"),
        ("", {"named": {}, "verdict": "none", "said": []}, "none"),
    ],
)
def test_a_trouble_is_judged(truth: str, record: dict[str, object], verdict: str) -> None:
    assert trouble.judged(truth, record) == verdict


def test_the_trials_cover_every_effect_in_every_excitation_and_every_colour() -> None:
    one = [case("one", index, 0) for index in range(len(KINDS) * len(EXCITATIONS))]
    covered = {(trial.effects[0].partition(":")[0], trial.excitation) for trial in one}
    assert covered == {(kind, excitation) for kind in KINDS for excitation in EXCITATIONS}
    assert set(EFFECTS) < set(KINDS)
    assert {trial.vehicle for trial in one} == {"leng", "small"}
    still = [case("quiet", index, 0) for index in range(48)]
    assert {(trial.autocorrelation, trial.excitation) for trial in still} == {
        (colour, excitation) for colour in AUTOCORRELATIONS for excitation in EXCITATIONS
    }
    for index in range(60):
        assert len(set(case("two", index, 0).effects)) == 2
        half = case("half", index, 0)
        assert half.size == 0.5
        assert half.effects == case("one", index, 0).effects


def test_the_missions_cover_every_kind_vehicle_and_effect_with_a_seed_of_its_own() -> None:
    still = list(quiet(3, 0))
    assert {(mission.kind, mission.vehicle) for mission in still} == {(k, v) for k in MISSIONS for v in VEHICLES}
    assert len({mission.seed for mission in still}) == len(still) == 3 * len(MISSIONS) * len(VEHICLES)
    assert {mission.effect for mission in still} == {None}
    assert {circumstance(mission) for mission in still} == {one.name for one in USUAL_LOGS + OTHER_LOGS}
    surveys = list(hidden("survey", "rov", 3, 0))
    assert set(FULL_SIZE) | {"heading_current"} == {mission.effect for mission in surveys}
    assert len({mission.seed for mission in surveys}) == len(surveys) == 3 * len(HIDDEN)
    asked = argparse.Namespace(
        first_seed=0, runs=3, hidden_runs=3, other_runs=1, only=None, kinds=MISSIONS, vehicles=tuple(VEHICLES)
    )
    found = len({(each.group, each.mission.seed) for each in missions.cases(asked)})
    assert found == 2 * len(still) + len(VEHICLES) * len(surveys) + (len(MISSIONS) - 3) * len(HIDDEN)
    some = list(quiet(2, 500, kinds=("transit",), vehicles=("rov",)))
    assert some == [mission for mission in quiet(2, 500) if (mission.kind, mission.vehicle) == ("transit", "rov")]


def test_a_live_mission_with_an_effect_is_its_twin_in_everything_else() -> None:
    loud, still = live_missions.drawn(7, True), live_missions.drawn(7, False)
    assert loud.effect in live_missions.EFFECTS
    assert live_missions.MIN_ONSET_S <= loud.onset <= live_missions.MAX_ONSET_S
    assert replace(loud, effect=None, onset=still.onset) == still


def test_bets_count_as_won_where_they_ever_reach_their_level() -> None:
    records = [
        {"seed": 1, "effect": "inertia", "won": won, "trials": 3} for won in (np.log(25.0), np.log(150.0), 0.0, 0.0)
    ]
    document = {"command": "c", "date": "d", "first_seed": 1, "records": [*records, {"seed": 1, "effect": "inertia"}]}
    text = bets_level.report(document)
    assert "| inertia | 4 | 2 (15–85 %) | 1 (5–70 %) | 0 (0–49 %) |" in text
    assert "1 of 5 pairs" in text


def test_the_error_of_a_parameter_is_in_parts_of_the_true_one() -> None:
    truth: dict[str, float | str] = {"delay_s": 0.25}
    near = mission_tracer.parameter_error("torque_delay", truth, {"torque_delay": {"delay_s": 0.2}})
    assert near == pytest.approx(0.2)
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


@pytest.mark.slow
def test_the_tracer_is_judged_by_what_was_hidden(outcome: Outcome) -> None:
    biased = mission_tracer.examine("surveys", play(replace(outcome.mission, effect="bias_torque")))
    assert biased["judged"] == "right"
    assert biased["parameter_error"] < 0.3
    carried = mission_tracer.examine("quiet", play(replace(outcome.mission, kind="station")))
    assert carried["judged"] == "refused"
    text = mission_tracer.report_quiet([carried]) + mission_tracer.report_hidden([biased], by="kind")
    assert "| bias_torque | 1 | 1 |" in text
    assert carried["refused"] in mission_tracer.sentences([carried], "refused")


@pytest.mark.slow
def test_the_missions_of_the_learner(tmp_path: Path) -> None:
    words = ["--only", "learner", "--runs", "1", "--kinds", "rate_control", "station", "--vehicles", "auv"]
    missions.main([*words, "--first-seed", "2000", "--processes", "1", "--out", str(tmp_path)])
    document = json.loads((tmp_path / "missions_learner.json").read_text(encoding="utf-8"))
    assert [record["policy"] for record in document["records"]] == ["paper", "weighted"] * 2
    driven = [record for record in document["records"] if record["kind"] == "rate_control"]
    assert all(record["near"] > 0.8 for record in driven)
    text = (tmp_path / "missions_learner.md").read_text(encoding="utf-8")
    assert "| rate_control | auv | 1 |" in text
    assert document["command"] in text


@pytest.mark.slow
def test_the_real_tracer_finds_what_is_hidden_and_nothing_where_nothing_is() -> None:
    for effects in (("coupling:sway",), ()):
        trial = Trial(seed=41, effects=effects, excitation="multisine", duration=300.0)
        record = trace_table.examine(("one" if effects else "quiet", trial))
        assert record["failure"] is None
        assert record["judged"] in ("right", "class"), record["named"]


@pytest.mark.slow
def test_the_table_of_trials(tmp_path: Path) -> None:
    counts = ["--one", "1", "--half", "0", "--two", "0", "--quiet", "1"]
    words = ["--processes", "1", "--first-seed", "50", "--minutes", "2", "--noise", "measured", "--out", str(tmp_path)]
    trace_table.main([*counts, *words])
    document = json.loads((tmp_path / "trace_table_measured.json").read_text(encoding="utf-8"))
    assert [record["group"] for record in document["records"]] == ["one", "quiet"]
    assert [record["seed"] for record in document["records"]] == [50, 50]
    text = (tmp_path / "trace_table_measured.md").read_text(encoding="utf-8")
    assert document["date"] in text
    assert document["command"] in text
    for heading in ("False alarms with nothing hidden", GROUPS["one"].capitalize()):
        assert f"## {heading}" in text
    assert "a torque that is measured" in text


@pytest.mark.slow
def test_the_table_of_the_second_simulator(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(second_table, "case", partial(second_cases.case, duration=180.0))
    words = ["--one", "1", "--half", "0", "--quiet", "1", "--first-seed", "20", "--processes", "1"]
    second_table.main([*words, "--out", str(tmp_path)])
    document = json.loads((tmp_path / "second_table.json").read_text(encoding="utf-8"))
    one, still = document["records"]
    assert len(one["hidden"]) == 1
    assert not still["hidden"]
    text = (tmp_path / "second_table.md").read_text(encoding="utf-8")
    assert "| one effect of realistic size |" in text
    assert document["command"] in text


@pytest.mark.slow
def test_a_log_with_a_fault_is_what_its_seed_says_and_the_command_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kind = "A4 a gyro that stands still for 30 s"
    log, again, other = (trouble.played(name, 1) for name in (kind, kind, "clean"))
    np.testing.assert_array_equal(log.columns["yaw_rate"], again.columns["yaw_rate"])
    assert 590 <= np.count_nonzero(np.diff(log.columns["yaw_rate"]) == 0.0) <= 610
    assert np.count_nonzero(np.diff(other.columns["yaw_rate"]) == 0.0) == 0
    monkeypatch.setattr(trouble, "KINDS", {kind: trouble.KINDS[kind]})
    words = ["--seeds", "1", "--first-seed", "1", "--processes", "1", "--out", str(tmp_path)]
    trouble.main(words)
    (record,) = json.loads((tmp_path / "trouble.json").read_text(encoding="utf-8"))["records"]
    assert record["judged"] == "said"
    assert "is constant" in record["said"][0]
    assert f"| {kind} | 0 | 0 | 1 | 0 | 0 | – |" in (tmp_path / "trouble.md").read_text(encoding="utf-8")
