"""`incsvr identify`: the vehicle file, the Python export that simulates alike, and refusals."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import incsvr
from incsvr.errors import BadInput
from incsvr.plant.axes import EFFORTS, VELOCITIES
from incsvr.vehicle import identify
from service.cli.command_line import main
from service.config.vehicle_file import read_vehicle
from service.fitting.identify import declared_by_file
from service.recordings.recording import Recording
from service.recordings.recording_csv import write
from simulator.vehicles import NAMES, torpedo
from tests.viewer.test_report import Text
from tests.worlds import swim
from viewer.report.figures import number


@pytest.fixture(scope="module")
def dives(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with two dives of one torpedo, and the vehicle file, JSON and report of `identify`."""
    folder = tmp_path_factory.mktemp("dives")
    body = torpedo(np.random.default_rng(51))
    for seed, (name, seconds) in enumerate((("one", 200.0), ("two", 60.0)), start=51):
        write(folder / f"{name}.csv", Recording(name, swim(body, seconds, seed)))
    words = ["identify", str(folder / "one.csv"), "--validate", str(folder / "two.csv"), "--name", "torpedo"]
    words += ["--write", str(folder / "vehicle.yaml"), "--report", str(folder / "report.html")]
    assert main([*words, "--json", str(folder / "found.json")]) == 0
    return folder


def test_the_vehicle_file_holds_what_the_json_holds(dives: Path) -> None:
    found = json.loads((dives / "found.json").read_text(encoding="utf-8"))
    assert read_vehicle(dives / "vehicle.yaml").to_dict() == found["vehicle"]
    assert found["free_run"]["on"] == "other recordings"
    yaw, linear = found["axes"]["yaw"], found["vehicle"]["terms"]["yaw"]["linear"]
    assert yaw["inertia"] == found["mass_matrix"]["yaw,yaw"]["value"]
    assert yaw["coefficients"]["N_r"] == {"estimate": linear["value"], "low": linear["low"], "high": linear["high"]}
    assert found["axes"]["heave"]["reason"].startswith("no heave was recorded")
    assert found["warnings"] == []
    assert found["free_run"]["horizons"]["5"]["yaw"]["model"] < 0.3 * found["free_run"]["horizons"]["5"]["yaw"]["hold"]


def test_the_report_shows_parameters_errors_and_a_free_run_and_loads_nothing(dives: Path) -> None:
    report = Text()
    text = (dives / "report.html").read_text(encoding="utf-8")
    report.feed(text)
    words = " ".join(" ".join(report.words).split())
    found = json.loads((dives / "found.json").read_text(encoding="utf-8"))
    inertia = found["vehicle"]["mass_matrix"]["yaw,yaw"]
    assert f"inertia [kg m²] {number(inertia['value'])} {number(inertia['low'])} to {number(inertia['high'])}" in words
    ahead = found["free_run"]["horizons"]["5"]["yaw"]
    alone = found["axes"]["yaw"]["by_itself"]["horizons"]["5"]["yaw"]["model"]
    assert f"yaw [rad/s] {number(ahead['model'])} {number(ahead['hold'])} {number(alone)}" in words
    assert "Heave: no heave was recorded" in words
    assert text.count("<svg") == 3, "a free run of each axis"
    assert not report.loads


def test_a_log_of_one_axis_without_yaw_is_identified(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rng = np.random.default_rng(52)
    time, force = np.arange(0.0, 120.0, 0.05), np.repeat(rng.choice([-40.0, -20.0, 0.0, 20.0, 40.0], 30), 80)
    surge = np.zeros(time.size)
    for k, push in enumerate(force[:-1].tolist()):
        u = surge[k]
        for _ in range(10):
            u += 0.005 * (push - 8.0 * u - 25.0 * u * abs(u)) / 60.0
        surge[k + 1] = u
    rows = np.column_stack([time, surge + rng.normal(0.0, 0.003, time.size), force])
    log = tmp_path / "ahead.csv"
    np.savetxt(log, rows, delimiter=",", header="t,u,thrust", comments="")
    assert main(["identify", str(log), "--column=surge=u", "--column=surge_force=thrust", "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["axes"]["surge"]["identified"]
    assert found["axes"]["surge"]["inertia"] == pytest.approx(60.0, rel=0.03)
    assert found["axes"]["yaw"]["reason"].startswith("no yaw_rate was recorded")


@pytest.mark.slow
def test_a_free_run_that_diverges_is_a_warning_with_its_cure(
    dives: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """On a dive whose efforts are those of another time: the text, the JSON and the report say so."""
    log = swim(torpedo(np.random.default_rng(51)), 60.0, 53)
    wrong = {
        name: (time, np.roll(values, values.size // 2) if name in EFFORTS else values)
        for name, (time, values) in log.items()
    }
    write(tmp_path / "wrong.csv", Recording("wrong", wrong))
    target, report = tmp_path / "found.json", tmp_path / "report.html"
    words = ["identify", str(dives / "one.csv"), "--validate", str(tmp_path / "wrong.csv"), "--report", str(report)]
    assert main([*words, "--json", str(target)]) == 0
    warnings = json.loads(target.read_text(encoding="utf-8"))["warnings"]
    assert [each.split(" diverges")[0] for each in warnings] == [
        f"the free run of {axis}" for axis in ("surge", "sway", "yaw")
    ]
    assert "record a manoeuvre that varies the surge speed" in warnings[0]
    assert f"warning: {warnings[0]}" in capsys.readouterr().out
    assert warnings[0][1:] in report.read_text(encoding="utf-8")


@pytest.mark.slow
def test_an_inertia_that_nothing_determines_is_not_called_estimated(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The yaw of a torpedo without its surge and sway, whose Coriolis moment drives it."""
    log = swim(torpedo(np.random.default_rng(58)), 150.0, 58)
    write(tmp_path / "yaw.csv", Recording("yaw", {name: log[name] for name in ("yaw_rate", "torque")}))
    target, report = tmp_path / "found.json", tmp_path / "report.html"
    assert main(["identify", str(tmp_path / "yaw.csv"), "--json", str(target), "--report", str(report)]) == 0
    found, text = json.loads(target.read_text(encoding="utf-8")), capsys.readouterr().out
    inertia = found["mass_matrix"]["yaw,yaw"]
    assert inertia["origin"] == "not excited"
    assert inertia["high"] > 2.0 * inertia["value"]
    assert "kg m² (not excited)" in text
    sentence = found["manoeuvres"][0]
    assert sentence.startswith("the yaw inertia is not excited: change the yaw effort in steps")
    assert sentence in text
    page = report.read_text(encoding="utf-8")
    assert sentence[1:] in page
    assert '<span class="flag">not excited</span>' in page


@pytest.mark.slow
def test_velocities_over_ground_in_a_current_are_a_warning() -> None:
    log = dict(swim(torpedo(np.random.default_rng(201)), 200.0, 201, (0.1, -0.1)))
    (warning,) = identify([log], validate=False).warnings
    said = re.search(r"a steady current of ([\d.]+) m/s towards (\d+)°", warning)
    assert said is not None
    assert [float(each) for each in said.groups()] == [pytest.approx(0.14, abs=0.02), pytest.approx(315.0, abs=10.0)]
    del log["heading"]
    assert identify([log], validate=False).warnings == ()


def test_the_python_export_simulates_alike(dives: Path, tmp_path: Path) -> None:
    module = tmp_path / "torpedo_model.py"
    assert main(["export", str(dives / "vehicle.yaml"), "--format", "python", "--out", str(module)]) == 0
    space: dict[str, object] = {}
    exec(compile(module.read_text(encoding="utf-8"), str(module), "exec"), space)
    log = swim(torpedo(np.random.default_rng(51)), 60.0, 54)
    vehicle = read_vehicle(dives / "vehicle.yaml")
    edges, course = vehicle.free_run(log)
    step = edges[1] - edges[0]
    efforts = np.array([log[name][1][:-1] if name in log else np.zeros(edges.size - 1) for name in EFFORTS]).T
    free_run = space["free_run"]
    assert callable(free_run)
    assert free_run(course[0], efforts, step) == pytest.approx(course, abs=1e-6)
    assert {*VELOCITIES, *EFFORTS} >= {name for name in log if name != "heading"}
    assert space["AXES"] == list(NAMES)


@pytest.mark.parametrize("text", ["", "a: 1\n", "vehicle_file: 1\nname: x\n", "[1, 2]\n", "{{{\n"])
def test_a_file_that_is_no_vehicle_is_refused_in_one_sentence(tmp_path: Path, text: str) -> None:
    path = tmp_path / "vehicle.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(BadInput, match=str(path)) as refused:
        read_vehicle(path)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--set", "vehicle.mass_matrix=a,b"], "six numbers from surge to yaw"),
        (["--set", "vehicle.mass_matrix=nan,0,0,0,0,1"], "an entry that is no finite number"),
        (["--set", "signals.smoothing=0.1"], "uses values of inputs or vehicle.mass_matrix alone"),
        (["--name", "a\nb"], "a name of one line"),
        (["--write", "no/such/folder.yaml"], "name a file in a folder that is there with --write"),
        (["--vehicle", "none.yaml"], "no such file; `incsvr identify LOG --write none.yaml` writes one"),
    ],
)
def test_a_flag_of_no_use_is_refused(
    dives: Path, capsys: pytest.CaptureFixture[str], words: list[str], told: str
) -> None:
    assert main(["identify", str(dives / "one.csv"), *words]) == 2
    assert told in capsys.readouterr().err
    flag, value = words
    keyword: Any = {flag.removeprefix("--"): value}
    with pytest.raises(BadInput, match=r"the result has write\(\)" if flag == "--write" else told):
        incsvr.identify(dives / "one.csv", **keyword)


def test_a_vehicle_file_declares_the_mass_matrix(
    dives: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`fit` and `trace` take the body of a vehicle file with another yaw inertia, `identify` its known values."""
    values = (dives / "vehicle.yaml").read_text(encoding="utf-8")
    copy, log = tmp_path / "other.yaml", str(dives / "one.csv")
    known = read_vehicle(dives / "vehicle.yaml").mass[("yaw", "yaw")].value
    copy.write_text(re.sub(r"(yaw,yaw\"?: {value: )[^,]+", rf"\g<1>{2.0 * known!r}", values), encoding="utf-8")
    assert main(["fit", log, "--vehicle", str(copy), "--json", "-"]) == 0
    fitted = json.loads(capsys.readouterr().out)
    assert fitted["inertia"] == 2.0 * known
    assert fitted["coupled"]["mass_matrix"][35] == 2.0 * known
    declared = declared_by_file(copy)
    assert declared[("yaw", "yaw")] == 2.0 * known
    copy.write_text(re.sub(r"(yaw,yaw\"?: {.*origin: )\w+", r"\g<1>assumed", values), encoding="utf-8")
    assert {*declared} - {*declared_by_file(copy)} == {("yaw", "yaw")}
    assert main(["fit", log, "--vehicle", str(copy), "--axis", "heave"]) == 2
    assert "it has no actuator along heave, but along yaw, surge, sway" in capsys.readouterr().err
    assert main(["fit", log, "--vehicle", str(copy), "--inertia", "3"]) == 2
    assert "leave out one of the two" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["identify", "compare"])
def test_a_wild_velocity_is_refused_with_its_time(
    dives: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    header, *rows = (dives / "one.csv").read_text(encoding="utf-8").splitlines()
    cells = rows[500].split(",")
    cells[header.split(",").index("sway")] = "900"
    wild = tmp_path / "wild.csv"
    wild.write_text("\n".join([header, *rows[:500], ",".join(cells), *rows[501:]]) + "\n", encoding="utf-8")
    assert main([command, str(dives / "two.csv"), str(wild)]) == 2
    assert "wild.csv: sway is 900 at 50 s, beyond the plausible ±60 m/s" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["identify", "ONE", "--validate", "ONE"], "one.csv is given twice, and data that was fitted proves nothing"),
        (["compare", "ONE", "ONE"], "a dive that counts twice makes changes look surer than they are"),
        (["fit", "--inertia", "40", "ONE", "--validate", "ONE"], "data that was fitted proves nothing"),
        (["compare", "ONE"], "at least two dives"),
    ],
)
def test_one_dive_is_no_two(words: list[str], reason: str, dives: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(dives / "one.csv") if word == "ONE" else word for word in words]) == 2
    assert reason in capsys.readouterr().err


@pytest.mark.slow
def test_a_drag_that_changes_between_dives_is_told_with_its_dive(tmp_path: Path) -> None:
    body = torpedo(np.random.default_rng(53))
    more = np.where(np.arange(6) == 5, 1.3, 1.0)
    fouled = replace(body, linear=body.linear * more, quadratic=body.quadratic * more)
    for seed, (name, each) in enumerate((("may", body), ("june", body), ("july", fouled))):
        write(tmp_path / f"{name}.csv", Recording(name, swim(each, 120.0, seed)))
    dives = [str(tmp_path / f"{name}.csv") for name in ("may", "june", "july")]
    target, history = tmp_path / "compared.json", tmp_path / "history.parquet"
    report = tmp_path / "compared.html"
    words = ["--json", str(target), "--table", str(history), "--report", str(report), "--name", "auv"]
    assert main(["compare", *dives, *words]) == 0
    found = json.loads(target.read_text(encoding="utf-8"))
    rows, cause = found["rows"], "the yaw drag alone changed"
    changed = [(row["dive"], row["axis"], row["quantity"]) for row in rows if row["changed"]]
    assert changed == [("july.csv", "yaw", "drag")]
    assert [each[: len(cause)] for each in found["explanations"]["july.csv"]] == [cause]
    page = report.read_text(encoding="utf-8")
    assert page.count("<svg") == 6
    assert "in july.csv" in page
    assert cause[1:] in page
    parquet = pytest.importorskip("pyarrow.parquet", reason="the extra logs is not installed")
    compared = incsvr.compare(dives)
    assert compared.to_dict() == found
    assert "july.csv: yaw drag changed by" in repr(compared)
    legends = [legend for part in compared.plot().subfigs for legend in part.legends]
    words = [text.get_text() for legend in legends for text in legend.get_texts()]
    assert (len(legends), words.count("changed here")) == (6, 1)
    with pytest.raises(BadInput, match="no column is recognised as yaw_rate"):  # a table of dives is no log
        incsvr.compare([history])
    again, stored = tmp_path / "again.json", tmp_path / "again.parquet"
    assert main(["compare", str(history), "--json", str(again), "--table", str(stored)]) == 0
    told = json.loads(again.read_text(encoding="utf-8"))
    yaw = next(row for row in rows if row["changed"])
    assert told["coefficients"] == len(rows)
    assert [(row["vehicle"], row["dive"], row["p_value"]) for row in told["changes"]] == [
        ("auv", "july.csv", pytest.approx(yaw["p_value"]))
    ]
    assert parquet.read_table(stored).equals(parquet.read_table(history))  # every column is kept, in one form
    assert main(["compare", str(history), dives[0]]) == 2
    assert main(["compare", str(history), "--report", str(report)]) == 2


@pytest.mark.slow
def test_without_a_change_it_says_which_change_the_dives_would_have_shown(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Dives of a torpedo's yaw alone, given in the wrong order; the same table is no second one."""
    body, at = torpedo(np.random.default_rng(54)), {"may": 1.70e9, "june": 1.71e9, "july": 1.72e9}
    for seed, (name, began) in enumerate(at.items()):
        streams = swim(body, 100.0, seed).items()
        dated = {key: (time + began, values) for key, (time, values) in streams if key in ("yaw_rate", "torque")}
        write(tmp_path / f"{name}.csv", Recording(name, dated))
    table, target, report = tmp_path / "dives.parquet", tmp_path / "compared.json", tmp_path / "compared.html"
    words = ["--json", str(target), "--report", str(report), "--table", str(table)]
    assert main(["compare", *(str(tmp_path / f"{name}.csv") for name in ("july", "june", "may")), *words]) == 0
    found, text = json.loads(target.read_text(encoding="utf-8")), capsys.readouterr().out
    assert [row["dive"] for row in found["rows"][:3]] == ["may.csv", "june.csv", "july.csv"]
    page = report.read_text(encoding="utf-8")
    for where in (text, page):
        assert "no change proven" in where.lower()
        assert "in the order of their stamps, which is not the order in which they were given" in where
    assert f", least change {found['rows'][1]['smallest_change']:.2g}" in text
    for each in found["shown"]:
        rows = [row for row in found["rows"] if f"{row['axis']} {row['quantity']}" in each["quantity"]]
        if each["why_none"] is None:
            (row,) = (row for row in rows if row["dive"] == each["dive"])
            assert abs(row["estimate"] - row["reference"]) < each["smallest_change"] == row["smallest_change"]
            assert f"would have been seen is {each['smallest_change']:.3g} " in text
        else:
            assert sum(row["determined"] for row in rows) < 2
            assert f"these dives cannot show a change of {each['quantity']}: {each['why_none']}" in text
    pytest.importorskip("pyarrow", reason="the extra logs is not installed")
    assert main(["compare", str(table), str(table)]) == 2
    assert "hold the same dive" in capsys.readouterr().err


@pytest.mark.slow
def test_dives_of_a_boat_cannot_show_a_change_along_an_axis_without_actuator(
    measured: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    dives = [measured / "blueboat" / f"run_{number}.csv" for number in (220, 224, 230, 234)]
    assert main(["compare", *map(str, dives)]) == 0
    text = capsys.readouterr().out
    assert "no change proven" in text
    assert "these dives cannot show a change of sway drag at 0.173 m/s: sway has no actuator" in text
    assert (
        "these dives cannot show a change of yaw inertia: its 95 % interval is wider than its value in 4 of 4" in text
    )
