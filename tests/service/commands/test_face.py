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
from tests.service.commands.test_each_log import STEP_S, rov, saved


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
def test_identify_and_compare_answer_as_the_commands_do(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    one, other = (str(saved(tmp_path, f"{seed}.csv", rov(seed))) for seed in (1, 2))
    assert main(["identify", one, "--json", "-"]) == 0
    printed = capsys.readouterr()
    same(incsvr.identify(one), printed.out, printed.err)
    assert main(["compare", one, other, "--json", "-"]) == 0
    printed = capsys.readouterr()
    same(incsvr.compare([one, other]), printed.out, printed.err)


def test_flags_of_a_log_stay_with_it(dive: Path, tmp_path: Path) -> None:
    other = tmp_path / "degrees.csv"
    recording = incsvr.read(dive).to_dict()["columns"]
    rows = zip(*recording.values(), strict=True)
    text = ["stamp,r,tau", *(",".join("" if v is None else repr(v) for v in row) for row in rows)]
    other.write_text("\n".join(text), encoding="utf-8")
    log = incsvr.read(other, column=["t=stamp", "yaw_rate=r", "torque=tau"])
    curve = incsvr.fit(log, inertia=350).to_dict()["curve"]
    assert np.allclose(curve["damping"], incsvr.fit(dive, inertia=350).to_dict()["curve"]["damping"], rtol=1e-6)
    with pytest.raises(incsvr.BadInput, match="different keywords"):
        incsvr.fit([log, incsvr.read(dive)], inertia=350)


def columns_of(log: Path) -> dict[str, Any]:
    return dict(incsvr.read(log).to_dict()["columns"])


def test_arrays_are_learned_as_the_file_that_holds_them(dive: Path, tmp_path: Path) -> None:
    """Streams of two rates, with nan where one was not sampled; a further channel; a frame of the same columns."""
    columns = columns_of(dive) | {"depth": np.linspace(0.0, 9.0, len(columns_of(dive)["t"]))}
    of_file, of_arrays = incsvr.fit(dive, inertia=350), incsvr.fit(columns, inertia=350)
    told = of_arrays.to_dict()
    assert told["next"] is None
    assert "What next" not in str(of_arrays)
    names = ("curve", "coefficients", "settings", "samples", "support_vectors", "remarks")
    assert [told[name] for name in names] == [of_file.to_dict()[name] for name in names]
    assert incsvr.read(columns).to_dict()["columns"].keys() == columns.keys()
    parquet, arrow = pytest.importorskip("pyarrow.parquet"), pytest.importorskip("pyarrow")
    parquet.write_table(arrow.table(columns), tmp_path / "dive.parquet")
    assert np.array_equal(incsvr.fit(tmp_path / "dive.parquet", inertia=350).model.weight, of_arrays.model.weight)


def test_a_data_frame_is_a_log(dive: Path) -> None:
    pandas = pytest.importorskip("pandas", reason="pandas is not installed")
    frame = pandas.DataFrame(columns_of(dive))
    frame["t"] = pandas.Timestamp("2026-05-01") + pandas.to_timedelta(frame["t"], unit="s")
    assert np.allclose(
        incsvr.fit(frame, inertia=350).predict([0.1]).damping, incsvr.fit(dive, inertia=350).predict([0.1]).damping
    )


def test_a_whole_vehicle_of_arrays_is_one_of_files(tmp_path: Path) -> None:
    columns = rov(1)
    arrays = {"t": STEP_S * np.arange(columns["yaw_rate"].size), **columns}
    path = saved(tmp_path, "one.csv", columns)
    for axis in ("sway", "yaw"):
        of_arrays, of_file = (incsvr.fit(log, inertia="estimate", axis=axis) for log in (arrays, path))
        assert of_arrays.to_dict()["inertia"] == of_file.to_dict()["inertia"]
        assert np.array_equal(of_arrays.model.weight, of_file.model.weight)


def test_a_log_is_scored_as_it_is_validated(dive: Path) -> None:
    unseen = dive.with_name("unseen.csv")
    write_log(unseen, 3)
    learned = incsvr.fit(dive, validate=unseen, inertia=350.0)
    validated = learned.to_dict()["validation"]
    for log in (unseen, columns_of(unseen), incsvr.read(unseen)):
        score, left = learned.score(log), learned.residual(log)
        assert (score.mae, score.rmse, score.free_run_rmse) == tuple(
            validated[name] for name in ("mae", "rmse", "free_run_rmse")
        )
        assert np.sqrt(np.mean(left.effort**2)) == pytest.approx(score.rmse)
        assert left.time.size == left.rate.size == score.samples
    with pytest.raises(incsvr.BadInput, match="log: no column is recognised as torque"):
        learned.score({"t": [0.0, 1.0], "yaw_rate": [0.0, 0.1]})


def test_a_fit_is_written_as_the_command_writes_it(dive: Path, tmp_path: Path) -> None:
    learned = incsvr.fit(dive, inertia=350.0)
    written, command = tmp_path / "one.yaml", tmp_path / "other.yaml"
    assert "the state is" in learned.write(written, name="n", state=tmp_path / "one")
    words = ["--inertia", "350", "--write", str(command), "--name", "n", "--state", str(tmp_path / "one"), "--force"]
    assert main(["fit", str(dive), *words]) == 0
    assert written.read_text(encoding="utf-8") == command.read_text(encoding="utf-8")
    with pytest.raises(incsvr.BadInput, match="force sets it aside, name and state name another one"):
        learned.write(written)


@pytest.mark.parametrize(
    ("keywords", "reason"),
    [
        ({"inertia": 350, "foo": 1}, "fit takes no foo; it takes preset, "),
        ({"inertia": 350, "polcy": "paper"}, "did you mean policy"),
        (
            {"inertia": 350, "set": {"signals.torque": "x"}},
            r'^set\["signals.torque"\]: .*\'measured\' or \'commanded\', not \'x\'',
        ),
        ({"inertia": 350, "torque": "measured"}, 'torque was removed; give set={"signals.torque": "commanded"} or'),
        ({"inertia": 350, "json": "-"}, "the result has to_dict"),
        ({"inertia": 350, "write": "c.yaml"}, r"the result has write\(\)"),
        ({"inertia": "heavy"}, "^inertia is heavy; give the moment of inertia"),
        ({"inertia": 350, "axis": "yam"}, "axis is yam; did you mean yaw"),
        ({"inertia": 350, "cut_from": "noon"}, "it is noon; give seconds of the log"),
        ({"inertia": 350, "column": "torque=-torque"}, 'turn the sign of one of them .*column="torque=torque"'),
        ({"inertia": 350, "column": "torque=tau"}, '^column="torque=tau": there is no tau'),
        ({}, 'the inertia is not known; give inertia=I .* inertia="estimate" to estimate'),
    ],
)
def test_a_refusal_names_the_keyword(keywords: dict[str, Any], reason: str, dive: Path) -> None:
    with pytest.raises(incsvr.BadInput, match=reason) as refused:
        incsvr.fit(dive, **keywords)
    assert "--" not in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"torque": None}, "log: no column is recognised as torque among t, yaw_rate; name it: column="),
        ({"yaw_rate": [0.0, 0.1]}, "log: t has .* values and yaw_rate has 2"),
        ({"torque": ["a", "b"]}, "torque holds what is no number"),
        ({"torque": np.ones((2, 3))}, "torque has 2 dimensions"),
        ({"torque": [1.0, np.inf]}, r"torque\[1\] is inf"),
    ],
)
def test_arrays_that_are_no_log_are_refused(change: dict[str, Any], reason: str, dive: Path) -> None:
    columns = {name: values for name, values in (columns_of(dive) | change).items() if values is not None}
    with pytest.raises(incsvr.BadInput, match=reason) as refused:
        incsvr.fit(columns, inertia=350)
    assert "incsvr inspect" not in str(refused.value)


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
        incsvr.read(3)
    with pytest.raises(incsvr.BadInput, match="needs a log"):
        incsvr.fit([])
    with pytest.raises(incsvr.BadInput, match="read takes no inertia"):
        incsvr.read("dive.csv", inertia=1)  # type: ignore[call-arg]
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
