"""What is declared of a log against its motion: an inertia or unit wrong by a factor, a wrong sign, a late torque."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.numerics import Array
from service.cli.command_line import main
from service.fitting.declaration import judge_declaration
from service.recordings.reading import read
from service.recordings.recording import Recording, from_table
from service.recordings.recording_csv import write
from simulator import leng
from tests.worlds import ROV, mission, slow, trial

STEP = 0.01
FLAG = "--column torque=torque*SCALE"


def driven(
    command: Callable[[Array], Array], delay: float = 0.0, *, inertia: float = 16.7, linear: float = 30.0
) -> Recording:
    """Five minutes at 20 Hz of a vehicle whose thrust comes `delay` [s] after the command, (n,) [s] → (n,) [N m]."""
    time: Array = STEP * np.arange(30_000, dtype=np.float64)
    moment, rate, rates = command(time - delay), 0.0, np.empty(time.size)
    for k, push in enumerate(moment.tolist()):
        rates[k] = rate
        rate += STEP * (push - linear * rate - 20.0 * rate * abs(rate)) / inertia
    noise = np.random.default_rng(3).normal(0.0, 0.003, time.size)
    columns = {"yaw_rate": (rates + noise)[::5], "torque": command(time)[::5]}
    return from_table("driven", time[::5], columns)


def swinging(*periods: float) -> Callable[[Array], Array]:
    return lambda time: np.asarray(sum(20.0 * np.sin(2.0 * np.pi * time / period) for period in periods))


def scaled(recording: Recording, scale: float, offset: float = 0.0) -> Recording:
    time, torque = recording.own_streams["torque"]
    return replace(recording, own_streams={**recording.own_streams, "torque": (time, offset + scale * torque)})


@pytest.fixture(scope="module")
def rov() -> Recording:
    """A small ROV of 0.6 kg m² under up to 8 N m."""
    return slow(4, 0.05, duration=120.0)


@pytest.mark.parametrize(
    ("scale", "inertia", "says"),
    [
        (1.0, 0.6 * 8.0, "the declared inertia needs "),
        (1.0, 0.6 / 8.0, "the declared inertia needs 0."),
        (1.0 / 8.0, 0.6, "the torque looks like a share of full thrust (all within ±1): scale it with "),
        (100.0 / 8.0, 0.6, "the torque may be in per cent of full thrust (all within ±100): scale it with "),
        (
            400.0 / 8.0,
            0.6,
            "the torque may be a servo's pulse minus its neutral, in µs (all within ±500): scale it with ",
        ),
    ],
)
def test_an_inertia_or_a_unit_that_is_wrong_by_a_factor_is_said_with_the_flag(
    rov: Recording, scale: float, inertia: float, says: str
) -> None:
    doubt = judge_declaration([scaled(rov, scale)], [], inertia, None, False).doubt
    assert doubt is not None
    assert doubt.startswith(says)
    for part in ("times the torque in this log", f"{inertia:.4g} kg m² declared", FLAG, "--inertia"):
        assert part in doubt


def test_a_servos_pulse_is_no_torque(rov: Recording) -> None:
    with pytest.raises(BadInput, match="looks like a servo's pulse in µs"):
        judge_declaration([scaled(rov, 50.0, 1500.0)], [], 0.6, None, False)


FURTHER: list[Callable[[], tuple[Recording, float]]] = [
    lambda: (slow(5, 0.2), ROV.inertia),
    *(lambda kind=kind: _mission(kind) for kind in ("transit", "waypoints", "station", "bursts", "one_sided")),
    *(lambda effect=effect: _trial(effect) for effect in ("inertia", "torque_lag", "dead_zone")),
]


@pytest.mark.parametrize(
    "outcome",
    [
        lambda: (leng.recording("T1", 0), leng.INERTIA),
        lambda: _mission("survey"),
        lambda: _trial("torque_delay"),
        *(pytest.param(outcome, marks=pytest.mark.slow) for outcome in FURTHER),
    ],
)
def test_of_what_is_declared_right_nothing_is_said(outcome: Callable[[], tuple[Recording, float]]) -> None:
    recording, inertia = outcome()
    found = judge_declaration([recording], [], inertia, None, False)
    assert (found.sentences, found.sign) == ((), None)
    assert found.runs == [recording]


def _mission(kind: str) -> tuple[Recording, float]:
    played = mission(kind, "auv", 5, 400.0)
    return played.recording, played.inertia


def _trial(effect: str) -> tuple[Recording, float]:
    played = trial(5, (effect,), duration=200.0)
    return played.recording, played.inertia


def test_a_torque_that_acts_late_is_put_on_time_and_not_turned() -> None:
    """A rotor and a link of 0.6 s under swings of 1.5 and 2.5 s: at its stamps the torque is against the turn."""
    late = driven(swinging(1.5, 2.5), 0.6, linear=6.0)
    depth = late.time, np.arange(late.time.size, dtype=np.float64)
    unseen = replace(late, name="unseen", own_streams={**late.own_streams, "depth": depth})
    found = judge_declaration([late], [unseen], 16.7, None, False)
    assert found.note is not None
    assert "the torque acts 0.6 s after its stamps" in found.note
    for recording in (*found.runs, *found.unseen):
        before, after = (one.streams()["torque"] for one in (late, recording))
        np.testing.assert_allclose(after[0] - before[0], 0.6, atol=1e-6)
        np.testing.assert_array_equal(after[1], before[1])
    assert found.unseen[0].streams()["depth"][0].size == late.time.size


@pytest.mark.parametrize("delay", [0.0, 0.3])
def test_a_wrong_sign_is_refused_with_what_turns_it(
    delay: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "turned.csv"
    write(path, scaled(driven(lambda time: np.asarray(40.0 * np.sign(np.sin(2.0 * np.pi * time / 9.0))), delay), -1.0))
    for command in ("fit", "trace"):
        assert main([command, str(path), "--inertia", "16.7"]) == 2
        said = capsys.readouterr().err.strip()
        assert "\n" not in said
        assert "count in opposite directions" in said
        assert "--column torque=-torque" in said
        assert "--assume-sign" in said
    assert main(["fit", str(path), "--inertia", "16.7", "--column", "torque=-torque"]) == 0


def test_where_sign_and_delay_cannot_be_told_apart_whoever_knows_the_sign_goes_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One sine: half a turn late is turned round."""
    path = tmp_path / "sine.csv"
    write(path, driven(swinging(1.0), 0.33))
    assert main(["fit", str(path), "--inertia", "16.7"]) == 2
    assert "in opposite directions, or the torque acts 0." in capsys.readouterr().err
    assert main(["fit", str(path), "--inertia", "16.7", "--assume-sign"]) == 0
    assert "after its stamps, and was shifted" in capsys.readouterr().out


@pytest.mark.slow
def test_the_measured_rov_with_five_times_its_inertia(measured: Path, capsys: pytest.CaptureFixture[str]) -> None:
    runs = [measured / "bluerov" / f"run_{number:02d}.csv" for number in (4, 5)]
    assert judge_declaration([read(run) for run in runs], [], 1.125, None, False).doubt is None
    for command in ("fit", "trace"):
        main([command, *map(str, runs), "--inertia", "5"])
        printed = capsys.readouterr()
        assert "the declared inertia needs 2.3 times the torque in this log" in printed.out + printed.err
