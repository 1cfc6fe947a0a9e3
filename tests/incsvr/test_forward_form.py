"""The forward form on ordinary missions: closed loop, water, exact commands; what it finds, and what it does not."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.tracing import Run, Trace, trace
from incsvr.tracing.forward.fit import fit
from incsvr.tracing.forward.grid import cells
from incsvr.tracing.forward.loop import loop_of
from simulator.missions import Mission, Outcome, play

SURVEY = Mission("survey", "auv", 7, duration=900.0)


def run_of(outcome: Outcome) -> Run:
    columns = dict(outcome.recording.columns)
    time = outcome.recording.time
    return Run(outcome.recording.name, time, columns.pop("yaw_rate"), columns.pop("torque"), columns)


def traced(mission: Mission) -> tuple[Outcome, Trace]:
    outcome = play(mission)
    return outcome, trace([run_of(outcome)], inertia=outcome.inertia)


@pytest.fixture(scope="module")
def survey() -> Outcome:
    return play(SURVEY)


def test_where_nothing_is_hidden_nothing_is_named_and_the_loop_is_told(survey: Outcome) -> None:
    found = trace([run_of(survey)], inertia=survey.inertia)
    assert found.verdict == "none"
    assert found.loop == "closed"
    assert not found.proven


def test_the_damping_of_a_closed_loop_is_not_biased_by_the_water(survey: Outcome) -> None:
    grid = cells([run_of(survey)], survey.inertia, [])
    rates = np.array([-0.4, -0.2, 0.2, 0.4])
    assert fit(grid).model.damping_at(rates) == pytest.approx(survey.damping(rates), rel=0.1)


def test_what_is_hidden_in_a_survey_is_found() -> None:
    outcome, found = traced(Mission("survey", "auv", 8, "bias_torque", duration=600.0))
    assert [finding.effect for finding in found.effects] == ["bias_torque"]
    truth = outcome.truth["moment_nm"]
    assert isinstance(truth, float)
    assert found.effects[0].parameters["moment_nm"] == pytest.approx(truth, rel=0.2)
    assert found.proven


def test_an_open_loop_and_a_measured_torque_are_told_from_the_data(survey: Outcome) -> None:
    bursts = play(Mission("bursts", "auv", 7, duration=900.0))
    clean = run_of(bursts)
    noise = np.random.default_rng(1).normal(0.0, 1.0, clean.time.size)
    measured = Run(clean.name, clean.time, clean.yaw_rate, clean.torque + noise)
    loops = [
        loop_of(grid, fit(grid))
        for grid in (cells([run], survey.inertia, []) for run in (run_of(survey), clean, measured))
    ]
    assert [(loop.closed, loop.commanded) for loop in loops] == [(True, True), (False, True), (False, False)]


def test_a_vehicle_that_holds_still_is_refused_with_its_figures_and_a_manoeuvre() -> None:
    outcome = play(Mission("station", "rov", 7, duration=900.0))
    with pytest.raises(BadInput, match=r"too little motion: .* rad/s .* drive turns both ways"):
        trace([run_of(outcome)], inertia=outcome.inertia)


def test_the_sign_of_the_torque_is_refused_in_closed_loop_too(survey: Outcome) -> None:
    run = run_of(survey)
    with pytest.raises(BadInput, match="multiply torque by −1"):
        trace([Run(run.name, run.time, run.yaw_rate, -run.torque)], inertia=survey.inertia, torque="commanded")
