"""The learner's studies: their judges, their streams, and a small run of each with the real learner."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.learner import (
    coverage,
    feedforward,
    forecast,
    policy,
    policy_measured,
    sensor_faults,
    several,
    slow_commands,
    thrust_faults,
)
from benchmarks.learner.policy_cases import ADAPTIVE, FITTED, scenario
from benchmarks.learner.policy_scenarios import RATES, SAMPLES_BEFORE, SCENARIOS
from benchmarks.learner.sensor_cases import Case
from benchmarks.learner.solver import measure
from benchmarks.vehicles.gaussian_process import gaussian_process
from incsvr.learning.learner import Settings
from simulator import leng
from tests.incsvr.learning import run


def test_the_feed_forward_halves_the_tracking_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(feedforward, "EXCITATION_S", 200.0)
    monkeypatch.setattr(feedforward, "CONTROL_S", 80.0)
    record = feedforward.examine(("bias_torque", 5))
    assert record["found"] == ["bias_torque"]
    assert record["with"] < 0.5 * record["alone"]
    assert "| bias_torque |" in feedforward.report({"command": "", "date": "", "revision": "", "records": [record]})


def test_lost_thrust_is_judged_by_when_it_was_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(thrust_faults, "MISSION_S", 420.0)
    monkeypatch.setattr(thrust_faults, "FAULT_S", 100.0)
    monkeypatch.setattr(thrust_faults, "MIN_ONSET_S", 220.0)
    monkeypatch.setattr(thrust_faults, "MAX_ONSET_S", 225.0)
    monkeypatch.setattr(thrust_faults, "FAULT_KINDS", ("rate_control",))
    record = thrust_faults.examine(("fault", 3, 10.0))
    assert (record["vehicle"], record["thruster"], record["told"], record["before"]) == ("auv", "none", True, [])
    assert record["after"] <= 70.0
    page = thrust_faults.report({"command": "", "date": "", "revision": "", "records": [record]})
    assert "| 3 | rate_control | auv | 0.50 |" in page


def test_an_effect_from_the_beginning_on_is_no_lost_thrust() -> None:
    """The log of `incsvr demo --log`: half of the error there is weak thrust to port, which comes and goes with τ."""
    assert thrust_faults.examine(("lasting", 1, 10.0))["false"] == []


def test_figures_of_the_solver() -> None:
    figures = measure(sets=10, few=1, offline=600)
    assert figures["n"] == 110
    assert figures["offline"]["n"] == 600
    assert figures["certified_error_nm"] <= 0.01
    assert figures["apart_from_clarabel_nm"] <= 1e-6
    assert figures["iterations"]["most"] <= 15
    assert figures["ratio_to_coordinate_descent"] > 20.0  # above a hundred on an idle core
    assert figures["offline"]["ratio_to_sklearn_svr_fit"] > 1.0


def test_the_judge_tells_a_wide_band_from_a_narrow_one_and_a_wrong_curve_from_a_right_one() -> None:
    first = next(iter(coverage.voyages(3)))[0]
    model = run(Settings(), first.training)[0].model
    samples, curve = coverage.judged(model, first)
    assert samples.min() > 0.85
    assert curve.min() > 0.7
    narrow, _ = coverage.judged(replace(model, sigma=0.1 * model.sigma), first)
    assert narrow.max() < 0.5
    _, wrong = coverage.judged(model, replace(first, truth=lambda rate: 3.0 * leng.damping(rate)))
    assert wrong[1:].max() < 0.2


@pytest.mark.slow
def test_the_study_of_the_bands(tmp_path: Path) -> None:
    coverage.main(["--seeds", "2", "--first-seed", "5", "--out", str(tmp_path)])
    document = json.loads((tmp_path / "coverage.json").read_text(encoding="utf-8"))
    assert len(document["records"]) == 2 * 2 * 3
    assert all(np.nanmean(record["samples"]) > 0.8 for record in document["records"])
    text = (tmp_path / "coverage.md").read_text(encoding="utf-8")
    assert "| Leng, T1 | weighted |" in text
    assert document["command"] in text


@pytest.mark.parametrize("name", list(SCENARIOS))
def test_a_scenario_is_reproducible_and_true(name: str) -> None:
    case = SCENARIOS[name]
    samples, again = case.draw(3), case.draw(3)
    np.testing.assert_array_equal(samples.damping, again.damping)
    assert not np.array_equal(samples.damping, case.draw(4).damping)
    assert len(samples) == case.samples
    # The mean residual to the truth, where neither outliers nor the disturbance are, is none.
    last = samples.take(slice(case.samples - 200, None))
    residual = last.damping - np.interp(last.yaw_rate, RATES, case.truth(case.samples - 100))
    assert abs(np.median(residual)) < 3.0
    assert case.event % 50 == 0


def test_the_hull_is_in_the_truth() -> None:
    np.testing.assert_array_equal(SCENARIOS["hull on"].truth(SAMPLES_BEFORE), leng.damping(RATES))
    np.testing.assert_allclose(SCENARIOS["hull on"].truth(SAMPLES_BEFORE + 1), leng.damping(RATES, True))


def test_the_weighted_policy_wins_where_it_should() -> None:
    for name in ("hull on", "low speed"):
        paper, weighted = scenario(name, 7, "paper"), scenario(name, 7, "weighted")
        for figure, value in paper.items():
            assert weighted[figure] < value


@pytest.mark.slow
def test_the_study_of_the_policies(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(policy_measured, "FOLDER", tmp_path / "none")
    words = ["--seeds", "1", "--first-seed", "11", "--only", "hull on", "zigzag", "--out", str(tmp_path)]
    policy.main(words)
    assert "their rows are left out" in capsys.readouterr().err
    result = json.loads((tmp_path / "policy.json").read_text(encoding="utf-8"))
    assert {row["name"] for row in result["rows"]} == {"T1 → V1", "T2 → V2", "T1, T2", "hull on", "mission: zigzag"}
    _, hull, zigzag = (record["baselines"] for record in result["records"])
    assert hull["least squares"] < 3.0  # linear + quadratic is what the hull leaves of the damping
    assert set(zigzag) == {*FITTED, ADAPTIVE}
    text = (tmp_path / "policy.md").read_text(encoding="utf-8")
    assert result["command"] in text


def test_a_row_says_how_often_the_weighted_policy_is_better() -> None:
    row = {"name": "hull", "figure": "RMS", "kind": "seed", "paper": [2.0, 4.0, 6.0], "weighted": [1.0, 5.0, 3.0]}
    document = {"command": "c", "date": "d", "seeds": "1–3", "rows": [row], "records": []}
    assert "| hull | RMS | 4.000 ± 2.000 | 3.000 ± 2.000 | 0.75 | 2 of 3 seeds |" in policy.report(document)


def test_the_rivals_of_several_velocities_follow_what_they_can() -> None:
    velocity = np.random.default_rng(1).uniform(-0.5, 0.5, (120, 3))
    damping = 3.0 * velocity[:, 0] * np.abs(velocity[:, 1]) + velocity[:, 1] * velocity[:, 2]
    for method, allowed in ((several.least_squares, 1e-9), (gaussian_process, 0.03)):
        predict = method(velocity[:80], damping[:80])
        assert np.abs(predict(velocity[80:]) - damping[80:]).mean() < allowed


@pytest.mark.slow
def test_the_study_of_several_velocities(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The decoupled learner is worse than any that knows the other velocities, and every figure is in the table."""
    monkeypatch.setattr(several, "VECTORS", (60,))
    monkeypatch.setattr(several, "SPLITS", ())
    words = ["--seeds", "1", "--first-seed", "910150", "--processes", "1", "--out", str(tmp_path)]
    several.main(words)
    (record,) = json.loads((tmp_path / "several.json").read_text(encoding="utf-8"))["records"]
    errors = record["errors"]
    assert set(errors) == set(several.methods())
    coupled = [errors[name] for name in errors if not name.startswith("decoupled")]
    assert max(coupled) < min(errors["decoupled paper 60"], errors["decoupled weighted 60"])
    told = record["learner"]["several weighted 60"]
    assert told["certified_error"] < 0.01
    assert 0.85 < told["held"] <= 1.0
    text = (tmp_path / "several.md").read_text(encoding="utf-8")
    for name, error in errors.items():
        assert f"| {name} | {error:.2f} |" in text


def test_a_case_of_several_velocities_is_judged_by_the_true_damping_of_another_run() -> None:
    case = several.Case.simulated(910151)
    assert case.truth.shape == case.unseen.yaw_rate.shape
    noise = case.unseen.damping - case.truth
    assert 1.0 < np.std(noise) < 6.0
    assert abs(np.mean(noise)) < 1.0
    assert not np.array_equal(case.fitted.yaw_rate[:50], case.unseen.yaw_rate[:50])


def test_the_study_of_slow_commands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(slow_commands, "EVERY", (0.5,))
    slow_commands.main(["--seeds", "1", "--out", str(tmp_path)])
    told, measured = json.loads((tmp_path / "slow_commands.json").read_text(encoding="utf-8"))["rows"]
    assert (told[-1], measured[-1]) == ("0 of 1", "1 of 1")


@pytest.mark.slow
def test_the_study_of_forecasts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In open loop the learner's intervals are narrower than those of who holds the last rate, and hold the truth."""
    monkeypatch.setattr(forecast, "MISSIONS", ())
    monkeypatch.setattr(forecast, "INERTIAS", {})
    forecast.main(["--seeds", "1", "--processes", "1", "--out", str(tmp_path)])
    rows = json.loads((tmp_path / "forecast.json").read_text(encoding="utf-8"))["rows"]
    assert [(row["horizon"], row["method"]) for row in rows[:3]] == [(1.0, name) for name in forecast.METHODS]
    of = {row["method"]: row for row in rows if row["horizon"] == 20.0}
    assert of["learner"]["rate_half"] < of["hold"]["rate_half"]
    assert of["learner"]["rate_covered"] >= 0.8 * of["learner"]["forecasts"] > 0


@pytest.mark.slow
def test_the_study_of_sensors_that_fail(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fault = "torque stuck at zero"
    one = Case(fault, heading=False, more=True, seed=11)
    monkeypatch.setattr(sensor_faults, "cases", lambda seeds: [one])
    monkeypatch.setattr(sensor_faults, "POLICIES", ("weighted",))
    words = ["--seeds", "1", "--days", "1", "--hours", "0.2", "--papers", "1", "--out", str(tmp_path)]
    sensor_faults.main(words)
    document = json.loads((tmp_path / "sensor_faults.json").read_text(encoding="utf-8"))
    assert [record["right"] for record in document["faults"]] == [True]
    assert document["paper"][0]["paused_batches"] == 0
    assert f"| {fault} | 1 of 1 |" in (tmp_path / "sensor_faults.md").read_text(encoding="utf-8")
