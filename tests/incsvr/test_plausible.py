"""What speaks against the declaration is a note; what cannot answer at all is refused; sound runs hear neither."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.samples import Array
from incsvr.tracing.run import Run
from incsvr.tracing.weak.declaration import apparent_inertia, remarks
from incsvr.tracing.weak.excitation import answered, only_noise
from incsvr.tracing.weak.posing import pose
from simulator.recordings import Recording, read
from simulator.trial import Trial, play
from simulator.trial_command import EXCITATIONS


def as_run(recording: Recording) -> Run:
    return Run(recording.name, recording.time, recording.columns["yaw_rate"], recording.columns["torque"])


def noise(seed: int, deviation: float, mean: float = 0.0) -> Array:
    return np.asarray(mean + deviation * np.random.default_rng(seed).normal(size=6000), dtype=np.float64)


TIME = np.asarray(0.05 * np.arange(6000), dtype=np.float64)


@pytest.mark.parametrize(
    ("excitation", "vehicle"),
    [("multisine", "leng"), ("sine", "small"), ("telegraph", "leng"), ("closed_loop", "small")],
)
def test_an_inertia_far_off_is_noted_and_one_that_effects_bring_forth_is_not(excitation: str, vehicle: str) -> None:
    for effects in ((), ("inertia",), ("torque_lag",)):
        outcome = play(Trial(5, effects, 1.0, vehicle, excitation, 0.9, 300.0))
        run = as_run(outcome.recording)
        assert remarks(pose([run], outcome.inertia, [])) == ()
        for wrong in (0.1, 10.0):
            (note,) = remarks(pose([run], wrong * outcome.inertia, []))
            assert f"check the declared {wrong * outcome.inertia:.4g} kg m²" in note
        ends = apparent_inertia(pose([run], outcome.inertia, []))
        assert ends is not None
        assert 0.4 < ends[0] / outcome.inertia <= ends[1] / outcome.inertia < 2.5


def test_the_note_says_the_inertia_that_the_recording_shows() -> None:
    outcome = play(Trial(5, (), 1.0, "leng", "multisine", 0.0, 300.0))
    (note,) = remarks(pose([as_run(outcome.recording)], 1e9, []))
    shown = float(note.split("about ")[1].split(" kg")[0])
    assert shown == pytest.approx(outcome.inertia, rel=0.2)


def test_a_torque_that_is_unrelated_says_nothing_of_the_inertia() -> None:
    run = as_run(play(Trial(5, (), 1.0, "leng", "multisine", 0.0, 300.0)).recording)
    other = as_run(play(Trial(6, (), 1.0, "leng", "telegraph", 0.0, 300.0)).recording)
    pushed, theirs = np.isfinite(run.torque), np.isfinite(other.torque)
    foreign = np.where(pushed, np.interp(run.time, other.time[theirs], other.torque[theirs]), np.nan)
    assert apparent_inertia(pose([replace(run, torque=foreign)], 350.0, [])) is None


def test_a_torque_that_is_zero_throughout_is_noted() -> None:
    run = as_run(play(Trial(5, (), 1.0, "leng", "multisine", 0.0, 300.0)).recording)
    (note,) = remarks(pose([replace(run, torque=np.where(np.isnan(run.torque), np.nan, 0.0))], 350.0, []))
    assert "zero throughout: if the thrusters were used, its stream is missing" in note


@pytest.mark.parametrize(
    "run",
    [
        Run("steady", TIME, noise(1, 0.002, 0.2), noise(2, 2.0, 60.0)),
        Run("drifting", TIME, noise(1, 0.002), noise(2, 3.5)),
        Run("stuck in the mud", TIME, noise(1, 0.002), np.asarray(60.0 * np.sign(np.sin(TIME / 5.0)))),
    ],
    ids=lambda run: run.name,
)
def test_a_torque_that_moves_nothing_answers_nothing(run: Run) -> None:
    problem = pose([run], 350.0, [])
    with pytest.raises(BadInput, match=r"does not move the vehicle.*record a run with varied commands"):
        answered(problem, "none", [run])
    # what a channel explains is a finding all the same
    answered(problem, "effects", [run])


@pytest.mark.parametrize("excitation", EXCITATIONS)
def test_a_sound_run_may_be_quiet(excitation: str) -> None:
    """Even where the gyro's noise is as large as the motion, the torque shows in it."""
    run = as_run(play(Trial(5, (), 1.0, "leng", excitation, 0.9, 300.0)).recording)
    assert not only_noise([run])
    loud = run.yaw_rate + float(np.nanstd(run.yaw_rate)) * np.random.default_rng(0).normal(size=run.time.size)
    for rate in (run.yaw_rate, np.asarray(loud, dtype=np.float64)):
        noisy = replace(run, yaw_rate=rate)
        answered(pose([noisy], 350.0, []), "none", [noisy])


@pytest.mark.parametrize("number", [*range(1, 7), *range(9, 16)])
def test_the_measured_runs_hear_nothing_but_that_two_had_no_torque(measured: Path, number: int) -> None:
    run = as_run(read(measured / "bluerov" / f"run_{number:02d}.csv"))
    said = remarks(pose([run], 1.125, []))
    assert [note.split(":")[0] for note in said] == (["the torque is zero throughout"] if number < 3 else [])
    assert not only_noise([run])
