"""`import incsvr` for people who write Python: the commands by call, with results that can be drawn."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import incsvr
from service.cli.command_line import main
from simulator.leng_at_sea import write_log
from tests.conftest import ROOT


@pytest.fixture(scope="module")
def dive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("logs") / "dive.csv"
    write_log(path, 1)
    return path


@pytest.fixture(scope="module")
def traced(dive: Path) -> incsvr.Result:
    return incsvr.trace(incsvr.read(dive), inertia=350.0)


def test_importing_it_loads_the_mathematics_alone() -> None:
    program = (
        "import sys, incsvr; "
        "sys.exit(sorted({m.partition('.')[0] for m in sys.modules} & {'service', 'simulator', 'viewer', 'zenoh'}))"
    )
    found = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False)
    assert found.stderr.strip() == "[]", found.stderr


def test_a_log_is_read_as_it_stands(dive: Path) -> None:
    log = incsvr.read(dive)
    columns = log.to_dict()["columns"]
    assert list(columns) == ["t", "yaw_rate", "torque"]
    rows = [line.split(",") for line in dive.read_text(encoding="utf-8").splitlines()[1:]]
    assert columns["torque"] == [float(row[2]) if row[2] else None for row in rows]
    json.dumps(log.to_dict(), allow_nan=False)


def same(result: incsvr.Result, out: str, err: str) -> None:
    """The call's result is the command's, in JSON and in words."""
    assert json.loads(json.dumps(result.to_dict(), allow_nan=False)) == json.loads(out)
    assert str(result) == err.strip()


@pytest.mark.slow
def test_fit_answers_as_the_command_does(dive: Path, capsys: pytest.CaptureFixture[str]) -> None:
    fitted, unseen = dive, dive.with_name("other.csv")
    write_log(unseen, 2)
    assert main(["fit", str(fitted), "--validate", str(unseen), "--inertia", "350", "--json", "-"]) == 0
    printed = capsys.readouterr()
    for recordings in (str(fitted), incsvr.read(fitted), [fitted]):
        same(incsvr.fit(recordings, validate=unseen, inertia=350.0), printed.out, printed.err)


@pytest.mark.slow
def test_trace_answers_as_the_command_does(
    dive: Path, traced: incsvr.Result, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["trace", str(dive), "--inertia", "350", "--json", "-"]) == 0
    printed = capsys.readouterr()
    same(traced, printed.out, printed.err)


@pytest.mark.slow
def test_flags_of_a_log_stay_with_it(dive: Path, tmp_path: Path) -> None:
    other = tmp_path / "degrees.csv"
    recording = incsvr.read(dive).to_dict()["columns"]
    rows = zip(*recording.values(), strict=True)
    text = ["stamp,r,tau", *(",".join("" if v is None else repr(v) for v in row) for row in rows)]
    other.write_text("\n".join(text), encoding="utf-8")
    log = incsvr.read(other, column=["t=stamp", "yaw_rate=r", "torque=tau"])
    curve = incsvr.fit(log, inertia=350).to_dict()["curve"]
    assert np.allclose(curve["damping"], incsvr.fit(dive, inertia=350).to_dict()["curve"]["damping"], rtol=1e-6)
    with pytest.raises(incsvr.BadInput, match="different flags"):
        incsvr.fit([log, incsvr.read(dive)], inertia=350)


@pytest.mark.parametrize(
    ("flags", "reason"),
    [
        ({"inertia": 350, "foo": 1}, "no flag --foo"),
        (
            {"inertia": 350, "set": {"signals.torque": "x"}},
            "--set signals.torque: .*'measured' or 'commanded', not 'x'",
        ),
        ({"inertia": 350, "torque": "measured"}, "--torque was removed; give --set signals.torque=commanded or"),
        ({"inertia": 350, "json": "-"}, "the result has to_dict"),
        ({}, "the inertia is not known"),
    ],
)
def test_a_wrong_flag_is_one_sentence(flags: dict[str, Any], reason: str, dive: Path) -> None:
    with pytest.raises(incsvr.BadInput, match=reason):
        incsvr.fit(dive, **flags)


@pytest.mark.parametrize("call", [incsvr.fit, incsvr.trace, incsvr.identify])
@pytest.mark.parametrize(
    "matrix", [5.0, [1.0, 2.0], np.eye(3), [[1.0], [2.0, 3.0]], np.ones((2, 18)), object(), ["a"] * 6]
)
def test_what_is_no_mass_matrix_is_refused(call: Any, matrix: Any, dive: Path) -> None:
    with pytest.raises(incsvr.BadInput, match=r"vehicle\.mass_matrix|the mass matrix has") as refused:
        call(dive, set={"vehicle.mass_matrix": matrix})
    assert "\n" not in str(refused.value)


def test_a_mass_matrix_is_a_list_or_an_array_as_well_as_a_text(dive: Path) -> None:
    diagonal = [60.0, 80.0, 75.0, 4.0, 12.0, 350.125]
    matrix = np.diag(diagonal)
    told = incsvr.fit(dive, set={"vehicle.mass_matrix": "60,80,75,4,12,350.125"}).to_dict()
    for given in (diagonal, matrix):
        found = incsvr.fit(dive, set={"vehicle.mass_matrix": given}).to_dict()
        assert found | {"next": told["next"]} == told


def test_what_is_no_log_is_refused() -> None:
    with pytest.raises(incsvr.BadInput, match="not int"):
        incsvr.read(3)  # type: ignore[arg-type]
    with pytest.raises(incsvr.BadInput, match="needs a recording"):
        incsvr.fit([])
    with pytest.raises(incsvr.BadInput, match="read takes no inertia"):
        incsvr.read("dive.csv", inertia=1)
    with pytest.raises(incsvr.BadInput, match="there is no such file"):
        incsvr.read("no_such.csv")


@pytest.mark.slow
def test_results_are_drawn(dive: Path, traced: incsvr.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("matplotlib", reason="the extra report is not installed")
    monkeypatch.setenv("MPLBACKEND", "Agg")
    log = incsvr.read(dive)
    results = (log, incsvr.fit(log, inertia=350), traced)
    lines = []
    for number, result in enumerate(results):
        figure = result.plot()
        figure.savefig(tmp_path / f"{number}.png")
        lines.append([line for axes in figure.axes for line in axes.get_lines() if len(line.get_xdata()) > 10])
    assert all(lines)


@pytest.mark.slow
def test_results_are_shown_as_the_terminal_shows_them(dive: Path, traced: incsvr.Result) -> None:
    assert repr(incsvr.read(dive)) == "dive.csv: 300 s of yaw_rate, torque"
    assert repr(traced) == str(traced)
    assert "torque_asymmetry" in repr(traced)


@pytest.mark.slow
def test_results_become_tables(dive: Path, traced: incsvr.Result) -> None:
    pytest.importorskip("pandas", reason="pandas is not installed")
    log = incsvr.read(dive)
    frame = log.to_frame()
    assert list(frame.columns) == ["t", "yaw_rate", "torque"]
    assert len(frame) == len(log.to_dict()["columns"]["t"])
    effects = traced.to_frame()
    assert list(effects["effect"]) == [e["effect"] for e in traced.to_dict()["effects"] for _ in e["parameters"]]
    assert (effects["low"] <= effects["estimate"]).all()
