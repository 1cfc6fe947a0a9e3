"""Every result says what it is good enough for and names the command that follows, which runs."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from incsvr.plant.axes import AXES
from incsvr.plant.words import YAW_WORDS, words_of
from service.bus.session import free_endpoint
from service.cli.command_line import main, parser_of
from service.cli.next_command import AXIS_FLAGS, following
from service.fitting.good_enough import closed_loop, compared_words, feed_forward, noticing, unknown, without_gyro
from simulator.leng_at_sea import write_log


def test_verdicts() -> None:
    assert feed_forward(1.0, 4.0, YAW_WORDS).verdict == "yes"
    assert feed_forward(3.0, 4.0, YAW_WORDS).verdict == "no"
    assert feed_forward(3.0, 0.0, YAW_WORDS).verdict == "no"
    free = without_gyro(0.01, 0.2, 0.1, YAW_WORDS)
    assert free.verdict == "yes"
    assert free.share == pytest.approx(0.1)
    assert "up to 5.7° RMS after 10 s, not 57°" in free.why
    away = without_gyro(None, 0.2, 0.1, YAW_WORDS)
    assert (away.verdict, away.to_dict()["share"]) == ("no", None)
    assert noticing(0.4, "damping").verdict == "no"
    assert closed_loop("heading without a gyro", YAW_WORDS).verdict == "unknown"
    assert unknown("feed-forward", 0.5, "why").to_dict()["share"] is None
    assert "1 m RMS after 10 s, not 10 m" in without_gyro(0.1, 1.0, 1.0, words_of(AXES["surge"])).why


@pytest.mark.parametrize(
    ("error", "sentence"),
    [
        (0.1143, "0.1143 rad/s, where no motion at all gives 0.128 and the first yaw rate kept 0.19: hardly anything"),
        (0.13, "nothing useful was learned"),
        (0.0128, "10 % of the smaller one"),
        (None, "the simulated motion runs away (no motion at all errs by 0.128 rad/s)"),
    ],
)
def test_the_free_run_is_put_in_words(error: float | None, sentence: str) -> None:
    assert sentence in compared_words(error, 0.128, 0.19, YAW_WORDS)


def test_the_command_that_follows_keeps_what_was_said_of_the_log() -> None:
    words = [
        "my dive.csv",
        "--column=torque=-tau",
        "--from",
        "10",
        "--to",
        "12:00:30",
        "--axis",
        "sway",
        "--assume-sign",
    ]
    words += ["--inertia", "30", "--set", "signals.smoothing=0.2", "--set", "signals.torque=measured"]
    args = parser_of(["fit"]).parse_args(["fit", *words, "--validate", "other.csv"])
    found = following(args, "trace", args.recordings, AXIS_FLAGS)
    again = parser_of(["trace"]).parse_args(shlex.split(found)[1:])
    for name in ("recordings", "validate", "column", "cut_from", "cut_to", "axis", "inertia", "assume_sign"):
        assert getattr(again, name) == getattr(args, name)
    assert again.set == ["signals.torque=measured"]


def follow(printed: str, command: str) -> list[str]:
    """The words of the command that a result names, which begins so."""
    (line,) = [line for line in printed.splitlines() if line.startswith("What next?")]
    words = shlex.split(line.removeprefix("What next?"))
    assert " ".join(words).startswith(f"incsvr {command}"), line
    return words[1:]


@pytest.mark.slow
def test_from_a_log_to_a_curve_with_effects(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write_log(Path("dive.csv"), 1)
    words = ["inspect", "dive.csv"]
    for after in ("fit dive.csv", "trace dive.csv", "trace dive.csv", "fit dive.csv", "fit dive.csv", "serve --config"):
        assert main(words) == 0
        printed = capsys.readouterr().out
        assert words[0] == "inspect" or "Good enough?\n  feed-forward? " in printed
        words = ["350" if word == "estimate" and words[0] == "fit" else word for word in follow(printed, after)]
    serve = ["-m", "service.cli.command_line", *words]
    settings = {**os.environ, "INCSVR_BUS__LISTEN": free_endpoint()}
    with subprocess.Popen([sys.executable, *serve], stderr=subprocess.PIPE, env=settings, text=True) as learner:
        assert learner.stderr is not None
        assert any("ready: " in line for line in learner.stderr)
        learner.terminate()
    assert main(["fit", "dive.csv", "--inertia", "350", "--json", "fit.json"]) == 0
    follow(capsys.readouterr().out, "trace dive.csv")
    assert main(["export", "fit.json", "--format", "gazebo", "--out", "yaw.sdf"]) == 0
    assert main(follow(capsys.readouterr().err, "export fit.json --format python")) == 0
    line = capsys.readouterr().err.splitlines()[-2]
    ran = subprocess.run([sys.executable, line.split()[-1]], capture_output=True, text=True, check=True)
    assert ran.stdout.startswith("yaw: ")


def test_a_log_without_a_torque_asks_for_its_column(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "half.csv"
    path.write_text("t,yaw_rate,u\n" + "".join(f"{0.1 * k},{0.01 * (k % 7)},{k % 5}\n" for k in range(300)))
    assert main(["inspect", str(path)]) == 0
    words = follow(capsys.readouterr().out, "inspect")
    assert words[-1] == "torque=COLUMN"
    assert main([*words[:-1], "torque=u"]) == 0
    follow(capsys.readouterr().out, "fit")


@pytest.mark.slow
def test_from_dives_compared_to_a_simulator(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for seed, name in enumerate(("may.csv", "june.csv")):
        write_log(Path(name), seed)
    words = ["compare", "may.csv", "june.csv"]
    for after in ("identify may.csv june.csv", "export vehicle.yaml", ""):
        assert main(words) == 0
        printed = capsys.readouterr()
        words = follow(printed.out + printed.err, after) if after else []
