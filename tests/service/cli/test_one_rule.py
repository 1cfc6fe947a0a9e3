"""What one command or file refuses, its sister refuses: numbers, what is given twice, control characters."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

from incsvr.errors import BadInput
from service import wire
from service.cli.command_line import main
from service.cli.display import Console
from service.cli.output import emit
from service.cli.parser import Parser
from service.cli.terminal import spelt_controls
from service.config.sources import read
from service.config.traced_effects import read_effects
from service.export.learned import of_file
from service.inputs.forms.decoding import Undecodable, decoder
from service.inputs.forms.own import InvalidMeasurement, parse
from service.learner.questions import parse_numbers

RECORDING = "t,yaw_rate,torque\n0,0.1,1\n1,0.1,350_0\n"
COMMANDS = [
    ["fit", "dive.csv", "--inertia", "350_0"],
    ["fit", "dive.csv", "--inertia", "1", "--set", "signals.smoothing=0_1"],
    ["fit", "dive.csv", "--inertia", "1", "--from", "1_0"],
    ["trace", "dive.csv", "--inertia", "350_0"],
    ["identify", "dive.csv", "--set", "vehicle.mass_matrix=1_0,1,1,1,1,1"],
    ["fit", "dive.csv", "--inertia", "350"],
    ["query", "0_1"],
    ["query", "0.1", "--wait", "1_0"],
    ["forecast", "--torque", "3_0"],
    ["forecast", "--profile", "plan.csv"],
    ["page", "--port", "91_10"],
    ["config", "check", "config.yaml"],
    ["config", "show", "--set", "vehicle.mass_matrix=[1, 1, 1, 1, 1, '1_0']"],
]


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_digits_with_an_underscore_are_no_number(
    words: Sequence[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "dive.csv").write_text(RECORDING, encoding="utf-8")
    (tmp_path / "plan.csv").write_text("t,torque\n0,1\n1,2_0\n", encoding="utf-8")
    (tmp_path / "config.yaml").write_text("vehicle: {inertia: 350_0}\n", encoding="utf-8")
    try:
        status = main(words)
    except SystemExit as end:
        status = int(str(end.code))
    said = capsys.readouterr()
    assert status == 2
    assert (said.err or said.out).count("\n") == 1


def test_digits_with_an_underscore_are_no_number_on_the_bus(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(BadInput, match="no list of numbers"):
        parse_numbers("rate", "0_1", "rad/s")
    for form in (wire.DampingQuery, wire.FeedforwardQuery, wire.ForecastQuery):
        fields = {name: ["0_1"] for name in ("t", "rate", "torque")}
        with pytest.raises(BadInput, match="give a finite number"):
            wire.decode(form, json.dumps(fields).encode())
    monkeypatch.setenv("INCSVR_VEHICLE__INERTIA", "350_0")
    with pytest.raises(BadInput, match="without _"):
        read()


@pytest.mark.parametrize(
    "words",
    [
        ["fit", "dive.csv", "--inertia", "3", "--inertia", "4"],
        ["fit", "dive.csv", "--inertia", "3", "--validate", "a.csv", "--validate", "b.csv"],
        ["fit", "dive.csv", "--inertia", "3", "--iner", "4"],
        ["identify", "dive.csv", "--write", "a.yaml", "--write", "b.yaml"],
        ["replay", "dive.csv", "--patient", "--patient"],
        ["config", "show", "--set", "vehicle.name=a", "--set", "vehicle.name=b"],
        ["fit", "dive.csv", "--inertia", "3", "--column", "yaw_rate=a", "--column", "yaw_rate=torque"],
    ],
    ids=" ".join,
)
def test_a_flag_that_is_given_twice_is_refused(
    words: Sequence[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "dive.csv").write_text("t,a,torque\n0,0.1,1\n1,0.1,3\n", encoding="utf-8")
    try:
        status = main(words)
    except SystemExit as end:
        status = int(str(end.code))
    assert status == 2
    assert "given twice" in capsys.readouterr().err


TWICE = b'{"t": 1, "value": 2, "\\u0074": 3, "rate": [0.1], "model": {}, "effects": []}'


def test_a_name_that_stands_twice_in_json_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidMeasurement, match="name_twice"):
        parse(TWICE)
    assert parse(b'{"t": 1, "value": 2, "unit": "t"}') == ([1], [2], None)
    for text in (TWICE, b"{t: 1, 't': 2}"):
        with pytest.raises(Undecodable, match="t is given twice"):
            decoder("json")(text)
    with pytest.raises(BadInput, match="t is given twice"):
        wire.decode(wire.DampingQuery, TWICE)
    path = tmp_path / "result.json"
    path.write_bytes(TWICE)
    for reads in (lambda path: read_effects(path, 1.0, ()), of_file):
        with pytest.raises(BadInput, match="t is given twice"):
            reads(path)


def test_control_characters_are_spelt_wherever_they_are_printed(capsys: pytest.CaptureFixture[str]) -> None:
    evil, spelt = "\x1b[31mred\x9b2J\rback\u202eover", "\\u001b[31mred\\u009b2J\\u000dback\\u202eover"
    args = Parser().parse_args([])
    args.json = "-"
    with spelt_controls():
        emit(args, {"name": evil}, f"the vehicle {evil}\n\tä–°")
        print(evil, file=sys.stderr)
        Console(stderr=True, width=200).print(evil, markup=False)
    said = capsys.readouterr()
    assert json.loads(said.out) == {"name": evil}
    assert not {"\x1b", "\x9b", "\r", "\u202e"} & set(said.out + said.err)
    printed, drawn = f"the vehicle {spelt}\n\tä–°\n{spelt}\n", spelt.replace("\\u000d", "")  # rich leaves it out
    assert said.err == f"{printed}{drawn}\n"


def test_the_name_of_a_column_reaches_no_terminal(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "dive.csv"
    path.write_text("t,\x1b]0;mine\x07,torque\n0,1,2\n1,1,2\n", encoding="utf-8")
    assert main(["fit", str(path), "--inertia", "1"]) == 2
    assert main(["inspect", str(path)]) in (0, 2)
    said = capsys.readouterr()
    assert "\\u001b]0;mine\\u0007" in said.out + said.err
    assert not {"\x1b", "\x07"} & set(said.out + said.err)
