"""Every cure with a flag in it is tried on the input that raised the sentence: then it is not said again."""

from __future__ import annotations

import shlex
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from incsvr.numerics import Array
from service.cli.command_line import main
from tests.service import link
from tests.service.commands.test_each_log import MAY, ONE, STEP_S, turned_by
from tests.service.logs.dive import dive

COUNT = MAY["torque"].size
T: Array = np.asarray(STEP_S * np.arange(COUNT), dtype=np.float64)
RATE, TORQUE = MAY["yaw_rate"], MAY["torque"]
FIT = ("fit", "--inertia", "0.6")
SWUM = link.swum(dive(seconds=60.0), armed_from=0.0)


def as_csv(folder: Path, columns: dict[str, Array]) -> Path:
    lines = [",".join(columns), *(",".join(map(str, row)) for row in zip(*columns.values(), strict=True))]
    (folder / "log.csv").write_text("\n".join(lines), encoding="utf-8")
    return folder / "log.csv"


@dataclass(frozen=True)
class Case:
    """An input, and what is said of it.

    Attributes:
        log: columns of a table, or messages of a telemetry log.
        words: the command, before and after the log.
        said: the begin of the sentence.
        flags: the cure, as it is written in it; `found` replaces what a person must know.
        status: of the command after the cure.
    """

    log: dict[str, Array] | list[link.Said]
    words: tuple[str, ...]
    said: str
    flags: str
    found: dict[str, str] = field(default_factory=dict)
    status: int = 0


WHOLE = {"t": T[: ONE["surge"].size], **ONE}


def names(rate: str = "gyro_z", torque: str = "tau", time: str = "time") -> dict[str, Array]:
    return {time: T, rate: RATE, torque: TORQUE}


CASES = {
    "no inertia": Case(names(), ("fit",), "the inertia is not known", "--inertia estimate"),
    "degrees per second": Case(
        {**names(), "gyro_z": np.degrees(RATE)}, FIT, "beyond the plausible", "--column yaw_rate=gyro_z:deg/s"
    ),
    "degrees per second in our own": Case(
        {"t": T, **MAY, "yaw_rate": np.degrees(RATE)}, FIT, "beyond the plausible", "--column yaw_rate=yaw_rate:deg/s"
    ),
    "degrees per second in a name with a space": Case(
        {"time": T, "yaw rate (rad/s)": np.degrees(RATE), "tau": TORQUE}, FIT, "beyond the plausible",
        "--column 'yaw_rate=yaw rate (rad/s):deg/s'",
    ),
    "a heading in degrees": Case(
        {**WHOLE, "heading": np.degrees(ONE["heading"])}, ("identify",), "heading looks like degrees",
        "--column heading=heading:deg",
    ),
    "whole numbers": Case(
        {**names(), "gyro_z": np.round(1000.0 * RATE)}, FIT, "whole numbers", "--column 'yaw_rate=gyro_z*0.001'"
    ),
    "an unknown rate": Case(
        names(rate="foo"), FIT, "no column is recognised as yaw_rate", "--column yaw_rate=COLUMN:deg/s",
        {"COLUMN:deg/s": "foo"},
    ),
    "an unknown torque": Case(
        names(torque="foo"), FIT, "no column is recognised as torque", "--column torque=COLUMN", {"COLUMN": "foo"}
    ),
    "an unknown time": Case(
        {**names(time="foo"), "foo": 1000.0 * T}, FIT, "no column is recognised as the time", "--column t=COLUMN:ms",
        {"COLUMN": "foo"},
    ),
    "milliseconds in name alone": Case(
        names(time="t(msec)"), FIT, "read as ms, as its name says", "--column 't=t(msec):s'"
    ),
    "seconds in name alone": Case(
        {"time_s": 1000.0 * T, "gyro_z": RATE, "tau": TORQUE}, ("inspect",), "read as ms", "--column t=time_s:ms"
    ),
    "an axis that turns instead": Case(
        {**names(), "gyro_z": 0.0 * RATE, "gyro_y": RATE}, FIT, "what turns is gyro_y", "--column yaw_rate=gyro_y"
    ),
    "opposite directions": Case(
        {**names(), "tau": -TORQUE}, FIT, "count in opposite directions", "--column torque=-tau"
    ),
    "opposite directions in our own": Case(
        {"t": T, **turned_by(MAY, "torque")}, FIT, "count in opposite directions", "--column torque=-torque"
    ),
    "opposite directions in a trace": Case(
        {"t": T, **turned_by(MAY, "torque")}, ("trace", *FIT[1:]), "count in opposite", "--column torque=-torque"
    ),
    "another effort's sign": Case(
        turned_by(WHOLE, "sway_force"), ("identify",), "sway force and sway velocity count in opposite",
        "--column sway_force=-sway_force",
    ),
    "a share of full thrust": Case(
        {**names(), "tau": TORQUE / 6.0}, FIT, "looks like a share of full thrust", "--column torque=tau*SCALE",
        {"SCALE": "6"},
    ),
    "a fraction of full thrust": Case(
        {**names(), "tau": TORQUE / 6.0}, (*FIT, "--column", "torque=tau:fraction"), "is a fraction of full thrust",
        "--column 'torque=tau*NEWTON_METRES'", {"NEWTON_METRES": "6"},
    ),
    "knots": Case(
        {**WHOLE, "surge": 1000.0 * ONE["surge"]}, ("identify",), "beyond the plausible ±60 m/s",
        "--column surge=surge:kn", {":kn": ":mm/s"},
    ),
    "no force along the axis": Case(
        {"time": WHOLE["t"], "v": ONE["surge"], "X": ONE["surge_force"]},
        ("fit", "--axis", "surge", "--inertia", "30"), "no surge velocity and no surge force found",
        "--column surge=NAME --column surge_force=NAME", {"surge=NAME": "surge=v", "force=NAME": "force=X"},
    ),
    "nothing told by the vehicle": Case(
        SWUM, FIT, "assumed a BlueROV2 (frame 1,",
        "--set 'inputs.parameters={FRAME_CONFIG: 2, MOT_1_DIRECTION: -1}'",
        {"-1}": "-1, MOT_2_DIRECTION: -1, MOT_3_DIRECTION: 1, MOT_4_DIRECTION: 1}"},
    ),
    "two vehicles": Case(
        link.in_order(link.parameters(), SWUM, link.of(2, [*link.parameters(), *SWUM])), FIT, "vehicle 2 is ignored",
        "--system 2",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_the_cure_is_tried(tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str) -> None:
    case = CASES[name]
    first, *rest = case.words
    path = link.as_tlog(tmp_path / "log.tlog", case.log) if isinstance(case.log, list) else as_csv(tmp_path, case.log)
    main([first, str(path), *rest])
    said = " ".join("".join(capsys.readouterr()).split())
    assert case.said in said
    assert case.flags in said
    flags = case.flags
    for known, replaced in case.found.items():
        flags = flags.replace(known, replaced)
    kept = [word for word in rest if not word.startswith("torque=") and word != "--column"]
    assert main([first, str(path), *kept, *shlex.split(flags)]) == case.status
    assert case.said not in " ".join("".join(capsys.readouterr()).split())
