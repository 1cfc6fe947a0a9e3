"""`incsvr fit` on ordinary missions and commands that come slowly: right, or it says why not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from incsvr.numerics import Array
from incsvr.signals.settings import TorqueKind
from service.cli.command_line import main
from service.fitting.fit import Fit
from service.fitting.terms import Terms
from service.fitting.training import AS_GIVEN
from service.recordings.reading import RATE_LIMIT
from service.recordings.recording_csv import write
from service.recordings.samples_from_recording import signals_for
from tests.service.commands.test_fit import fit
from tests.worlds import ROV, mission, slow


@pytest.mark.parametrize(("kind", "policy"), [("station", "paper"), ("carried", "weighted")])
def test_too_little_motion_is_refused_with_its_figures_and_a_manoeuvre(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, kind: str, policy: str
) -> None:
    path = tmp_path / "still.csv"
    write(path, mission(kind, "auv", 1, 400.0).recording)
    assert main(["fit", str(path), "--inertia", "24", "--policy", policy]) == 2
    said = capsys.readouterr().err.strip()
    assert "too little motion" in said
    assert "rad/s" in said
    assert "drive steps of torque" in said
    assert "\n" not in said


@pytest.mark.slow
def test_a_survey_in_closed_loop_gives_its_curve_and_says_that_its_inertia_is_none(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    survey, path = mission("survey", "auv", 2, 900.0), tmp_path / "survey.csv"
    write(path, survey.recording)
    result = fit(capsys, path, "--inertia", "24")
    assert not any("closed loop" in remark for remark in result["remarks"])
    curve = {name: np.array(values) for name, values in result["curve"].items()}
    assert [curve["rate"][0], curve["rate"][-1]] == result["trained_range"]
    true = survey.damping(curve["rate"])
    allowed = np.maximum(0.1 * np.abs(true), 1.5 * survey.water_rms[5])
    assert (np.abs(curve["damping"] - true) <= allowed).all()
    assert np.mean(np.abs(curve["damping"] - true) <= 1.96 * curve["doubt"]) >= 0.9
    for name, expected in (("N_r", 9.0), ("N_r|r|", 26.0)):
        assert result["coefficients"][name]["low"] < expected < result["coefficients"][name]["high"]
    estimated = fit(capsys, path, "--inertia", "estimate")
    assert any("closed loop" in remark for remark in estimated["remarks"])
    assert estimated["inertia_standard_error"] is None


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "vehicle", "seed"),
    [("survey", "rov", 5101), ("pipeline", "auv", 5003), ("waypoints", "rov", 5007), ("one_sided", "rov", 780601)],
)
def test_sensors_that_are_sound_are_not_suspected_on_ordinary_missions(kind: str, vehicle: str, seed: int) -> None:
    """The water moves the vehicle for most of the time, and a controller answers it: no sensor fails by that."""
    outcome = mission(kind, vehicle, seed, 900.0)
    signals = signals_for([outcome.recording], outcome.inertia, RATE_LIMIT)
    fit = Fit.of([outcome.recording], [], signals)
    assert fit.put_aside == 0
    others = ("excitation", "the damping curve may be", "smoothing over")
    about_sensors = [remark for remark in fit.remarks if not any(each in remark for each in others)]
    assert not about_sensors


def examine(every: float, torque: TorqueKind | None) -> tuple[Array, bool]:
    """The error of the learned curve at ±0.5 to ±1.5 rad/s [%], and whether a remark says that it may be off."""
    recording, rates = slow(13, every), np.array([-1.5, -1.0, -0.5, 0.5, 1.0, 1.5])
    signals = signals_for([recording], ROV.inertia, RATE_LIMIT, torque)
    learned = Fit.of([recording], [], signals, Terms(by_person=AS_GIVEN))
    off = learned.predict(rates).damping / ROV.damping(rates) - 1.0
    return 100.0 * off, any("the damping curve may be" in remark for remark in learned.remarks)


@pytest.mark.parametrize(
    ("every", "allowed"), [(0.5, 0.25), *(pytest.param(every, 0.15, marks=pytest.mark.slow) for every in (0.2, 0.1))]
)
def test_commands_that_come_slowly_are_learned_right(every: float, allowed: float) -> None:
    off, says = examine(every, None)
    assert np.abs(off).max() < 100.0 * allowed
    assert not says


def test_or_it_is_said_by_how_much_the_curve_may_be_off() -> None:
    off, says = examine(0.5, "measured")
    assert np.abs(off).max() > 25.0
    assert says


def test_a_command_that_never_holds_is_the_reason_that_is_said(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = tmp_path / "quick.csv"
    write(path, slow(4, 0.05, changes=(0.3, 0.7), duration=90.0))
    assert main(["fit", str(path), "--inertia", "0.6", "--set", "signals.torque=commanded"]) == 2
    said = capsys.readouterr().err.strip()
    assert "because the torque is declared a command" in said
    assert "without `signals.torque: commanded`" in said
