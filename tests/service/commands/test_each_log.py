"""Each log by itself before several are believed together: signs, units and delays, hands, places and frames."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.numerics import Array
from service.cli.command_line import main, parser_of
from service.fitting.each_log import refuse_dives
from service.fitting.identify import configured
from service.fitting.request import Request, read_body
from service.recordings.recording import Recording, from_table
from service.recordings.recording_csv import write

STEP_S = 0.05
MASS, LINEAR, QUADRATIC = (np.array(each) for each in ((30.0, 45.0, 2.0), (8.0, 14.0, 1.5), (35.0, 80.0, 3.0)))
REACH = np.array([30.0, 35.0, 8.0])
VELOCITIES, EFFORTS = ("surge", "sway", "yaw_rate"), ("surge_force", "sway_force", "torque")
FLAGS = re.compile(r"(?:--(?:column|set) (?:'[^']*'|[^\s;,)]+) ?)+")


def rov(seed: int, seconds: float = 60.0, offset: float = 0.0) -> dict[str, Array]:
    """A vehicle in the plane under random steps; its centre of mass lies `offset` ahead [m]."""
    rng = np.random.default_rng(seed)
    count, within = round(seconds / STEP_S), 10
    levels = np.repeat(rng.uniform(-1.0, 1.0, (count // 12 + 1, 3)), 12, axis=0)[:count] * REACH
    mass = np.diag(MASS)
    mass[1, 2] = mass[2, 1] = MASS[1] * offset
    velocity, heading, found = np.zeros(3), 0.0, np.zeros((count, 4))
    for k in range(count):
        found[k] = *velocity, heading
        for _ in range(within):
            u, v, r = velocity
            sideways = MASS[1] * v + mass[1, 2] * r
            coriolis = np.array([-sideways * r, MASS[0] * u * r, sideways * u - MASS[0] * u * v])
            drag = LINEAR * velocity + QUADRATIC * velocity * np.abs(velocity)
            velocity = velocity + STEP_S / within * np.linalg.solve(mass, levels[k] - coriolis - drag)
            heading += STEP_S / within * velocity[2]
    noisy = found[:, :3] + rng.standard_normal((count, 3)) * [0.004, 0.004, 0.003]
    columns = dict(zip(VELOCITIES, noisy.T, strict=True)) | dict(zip(EFFORTS, levels.T, strict=True))
    return {**columns, "heading": (found[:, 3] + np.pi) % (2.0 * np.pi) - np.pi}


def turned_by(columns: dict[str, Array], *names: str) -> dict[str, Array]:
    return {name: -values if name in names else values for name, values in columns.items()}


def at(columns: dict[str, Array], ahead: float, aside: float) -> dict[str, Array]:
    """The velocities as a sensor at this place has them."""
    rate = columns["yaw_rate"]
    return {**columns, "surge": columns["surge"] - aside * rate, "sway": columns["sway"] + ahead * rate}


def in_world(columns: dict[str, Array], swapped: bool) -> dict[str, Array]:
    cos, sin = np.cos(columns["heading"]), np.sin(columns["heading"])
    north, east = columns["surge"] * cos - columns["sway"] * sin, columns["surge"] * sin + columns["sway"] * cos
    return {**columns, "surge": east if swapped else north, "sway": north if swapped else east}


def saved(folder: Path, name: str, columns: dict[str, Array]) -> Path:
    time: Array = np.asarray(STEP_S * np.arange(columns["yaw_rate"].size), dtype=np.float64)
    write(folder / name, from_table(name, time, columns))
    return folder / name


def judge(paths: list[Path], *flags: str) -> list[Recording]:
    """What `identify` and `compare` refuse before they fit."""
    args = parser_of(["compare"]).parse_args(["compare", *map(str, paths), *flags])
    request = Request.of(args, "dives")
    reading = request.reading(configured(request)[0])
    runs = [run for path in paths for run in read_body(reading, [path])]
    refuse_dives(runs)
    return runs


ONE, OTHER = rov(1), rov(2)


def test_vehicles_of_one_hand_pass(tmp_path: Path) -> None:
    judge([saved(tmp_path, "one.csv", ONE), saved(tmp_path, "other.csv", OTHER)])
    judge([saved(tmp_path, "ahead.csv", rov(3, offset=0.1))])  # a centre of mass ahead is no lever
    judge([saved(tmp_path, "body.csv", {name: values for name, values in ONE.items() if name != "heading"})])
    judge([saved(tmp_path, "port.csv", turned_by(ONE, "sway", "sway_force", "yaw_rate", "torque", "heading"))])


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        (turned_by(ONE, "sway", "sway_force"), "sway counts in the other direction than surge and yaw"),
        (turned_by(ONE, "yaw_rate", "torque", "heading"), "(or yaw than surge and sway)"),
        (turned_by(ONE, "surge", "surge_force"), "the Coriolis forces of all of them are reversed"),
        (turned_by(ONE, "sway_force"), "sway force and sway velocity count in opposite directions"),
        (turned_by(ONE, "surge"), "surge force and surge velocity count in opposite directions"),
        (at(ONE, 0.4, 0.0), "velocities of a place 0.40 m ahead of where the efforts act"),
        (at(ONE, -0.25, 0.3), "velocities of a place 0.25 m behind where the efforts act, and 0.30 m beside it"),
        (in_world(ONE, False), "look like velocities to the north and east"),
        (in_world(ONE, True), "look like velocities to the east and north"),
        (turned_by(in_world(ONE, False), "sway"), "east counted to the other side than the heading"),
        (turned_by(in_world(ONE, True), "surge"), "east counted to the other side than the heading"),
        ({**ONE, "heading": np.degrees(ONE["heading"])}, "heading looks like degrees"),
    ],
)
def test_another_hand_place_or_frame_is_named_and_its_cure_mends_it(
    tmp_path: Path, columns: dict[str, Array], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path, written = saved(tmp_path, "dive.csv", columns), tmp_path / "vehicle.yaml"
    assert main(["identify", str(path), "--write", str(written)]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert not written.exists()
    cure = FLAGS.search(said)
    assert cure is not None
    flags = shlex.split(cure[0])
    try:
        mended = judge([path], *flags)[0].own_streams
    except BadInput as error:  # an axis that now agrees with its effort may still count to the other side
        assert "opposite" in said
        again = FLAGS.search(str(error))
        assert again is not None
        judge([path], *flags, *shlex.split(again[0]))
        return
    if "velocities" in said:
        for name in ("surge", "sway"):
            np.testing.assert_allclose(mended[name][1], ONE[name], atol=0.03)


def late(values: Array, samples: int) -> Array:
    return np.asarray(values[np.maximum(np.arange(values.size) - samples, 0)])


def spinning(seed: int) -> dict[str, Array]:
    """Yaw by itself."""
    rng = np.random.default_rng(seed)
    torque = np.repeat(rng.uniform(-6.0, 6.0, 70), 18)
    rate, found = 0.0, np.zeros(torque.size)
    for k, push in enumerate(torque):
        found[k] = rate
        for _ in range(10):
            rate += STEP_S / 10 * (push - 0.6 * rate - 1.6 * rate * abs(rate)) / 0.6
    return {"yaw_rate": found + 0.004 * rng.standard_normal(found.size), "torque": torque}


MAY, JUNE, JULY = spinning(5), spinning(6), spinning(7)
TIME_COUNT = MAY["yaw_rate"].size


@pytest.mark.parametrize(
    ("june", "words", "cured"),
    [
        ({**JUNE, "torque": -JUNE["torque"]}, "count in opposite directions", True),
        ({**JUNE, "yaw_rate": -JUNE["yaw_rate"]}, "count in opposite directions", True),
        ({**JUNE, "torque": JUNE["torque"] / 6.0}, "as a share of full thrust is (all within ±1)", True),
        ({**JUNE, "torque": 20.0 * JUNE["torque"]}, "inertia and drag alike: another unit", True),
        ({**JUNE, "yaw_rate": np.degrees(JUNE["yaw_rate"])}, "if it is in degrees per second", True),
        ({**JUNE, "yaw_rate": late(JUNE["yaw_rate"], 3)}, "the yaw rate is 0.14 s later against the torque", False),
        ({**JUNE, "torque": late(JUNE["torque"], 2)}, "the torque is 0.1 s later against the yaw rate", False),
    ],
)
def test_a_fault_of_one_dive_is_no_change_of_the_vehicle(
    tmp_path: Path, june: dict[str, Array], words: str, cured: bool
) -> None:
    paths = [saved(tmp_path, f"{name}.csv", each) for name, each in (("may", MAY), ("june", june), ("july", JULY))]
    with pytest.raises(BadInput) as caught:
        judge(paths)
    said = str(caught.value)
    assert words in said
    assert "june.csv" in said
    cure = FLAGS.search(said)
    assert (cure is not None) == cured
    judge(paths, *shlex.split(cure[0])) if cure else judge([paths[0], paths[2]])


@pytest.mark.parametrize("words", [["fit", "--inertia", "0.6"], ["trace", "--inertia", "0.6"], ["identify"]])
def test_every_command_names_a_late_log(tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str]) -> None:
    dives = (("may", MAY), ("june", {**JUNE, "torque": late(JUNE["torque"], 2)}), ("july", JULY))
    paths = [str(saved(tmp_path, f"{name}.csv", each)) for name, each in dives]
    assert main([words[0], *paths, *words[1:]]) == 2
    assert "june.csv: the torque is 0.1 s later against the yaw rate" in capsys.readouterr().err


@pytest.mark.parametrize("words", [["fit", "--inertia", "0.6"], ["trace", "--inertia", "0.6"], ["identify"]])
def test_no_effort_at_all_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str]) -> None:
    cancelled = {**MAY, "torque": 1e-15 * MAY["torque"]}
    assert main([words[0], str(saved(tmp_path, "may.csv", cancelled)), *words[1:]]) == 2
    said = capsys.readouterr().err
    assert "may.csv: the torque is " in said
    assert "throughout, while the yaw rate goes up to" in said


def test_columns_of_zeros_are_no_axes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """An attitude without its rates of roll and pitch holds zeros there."""
    zeros = {name: np.zeros(TIME_COUNT) for name in ("roll_rate", "pitch_rate")}
    assert main(["identify", str(saved(tmp_path, "may.csv", {**MAY, **zeros}))]) == 0
    assert "roll is not identified: no roll_rate was recorded that changes" in capsys.readouterr().out


def test_real_changes_pass(tmp_path: Path) -> None:
    heavier = {**JUNE, "yaw_rate": 0.5 * JUNE["yaw_rate"]}
    judge([saved(tmp_path, "may.csv", MAY), saved(tmp_path, "june.csv", heavier), saved(tmp_path, "july.csv", JULY)])


def test_a_flag_for_a_log_that_is_not_read_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=r"there is no log juni\.csv among may\.csv"):
        judge([saved(tmp_path, "may.csv", MAY)], "--column", "juni.csv:torque=-torque")
