"""Every cure is tried on the input that raised its sentence: then the sentence is not said again."""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from incsvr.numerics import Array
from service.cli.command_line import main
from service.fitting.cures import CURES
from service.recordings.recording import Recording
from tests.service import link
from tests.service.commands.test_each_log import (
    EFFORTS,
    JULY,
    JUNE,
    MAY,
    ONE,
    STEP_S,
    VELOCITIES,
    at,
    in_world,
    late,
    turned_by,
)
from tests.service.logs.dive import dive
from tests.worlds import slow

COUNT = MAY["torque"].size
T: Array = np.asarray(STEP_S * np.arange(COUNT), dtype=np.float64)
RATE, TORQUE = MAY["yaw_rate"], MAY["torque"]
FIT = ("fit", "--inertia", "0.6")
SWUM = link.swum(dive(seconds=60.0), armed_from=0.0)


def as_csv(path: Path, columns: dict[str, Array]) -> Path:
    lines = [",".join(columns), *(",".join(map(str, row)) for row in zip(*columns.values(), strict=True))]
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


@dataclass(frozen=True)
class Case:
    """An input, and what is said of it.

    Attributes:
        log: columns of a table, or messages of a telemetry log.
        words: the command, before and after the log.
        said: the begin of the sentence.
        flags: the cure, as it is written in it; `found` replaces what a person must know.
        cures: the ids of the cures in it, where the table has them.
        drops: the words that the cure takes away.
        beside: whether may.csv and july.csv are read beside it; it is june.csv.
        status: of the command after the cure.
    """

    log: dict[str, Array] | list[link.Said]
    words: tuple[str, ...]
    said: str
    flags: str
    found: dict[str, str] = field(default_factory=dict)
    cures: tuple[str, ...] = ()
    drops: tuple[str, ...] = ()
    beside: bool = False
    status: int = 0


WHOLE = {"t": T[: ONE["surge"].size], **ONE}
NORTH = in_world(ONE, False)
PLANAR = (*VELOCITIES, *EFFORTS)
MATRIX = "30,45,35,1,1,2"
FINE = {
    "t": np.arange(15_000.0) * 2.0,
    "yaw_rate": np.interp(np.arange(15_000) * 0.002, T, RATE),
    "torque": np.repeat(TORQUE[:600], 25),
}
"""Half a minute, its stamps in milliseconds."""


def turned_heading(columns: dict[str, Array], by: float) -> dict[str, Array]:
    return {**columns, "heading": (columns["heading"] + by + np.pi) % (2.0 * np.pi) - np.pi}


def columns_of(recording: Recording) -> dict[str, Array]:
    """The columns of a recording in which no torque repeats itself."""
    unlike = 1e-6 * np.random.default_rng(1).standard_normal(recording.time.size)
    return {"t": recording.time, **recording.columns, "torque": recording.columns["torque"] + unlike}


def names(rate: str = "gyro_z", torque: str = "tau", time: str = "time") -> dict[str, Array]:
    return {time: T, rate: RATE, torque: TORQUE}


CASES = {
    "no inertia": Case(names(), ("fit",), "the inertia is not known", "--inertia estimate", cures=("inertia",)),
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
        "--column heading=heading:deg", cures=("heading",)
    ),
    "whole numbers": Case(
        {**names(), "gyro_z": np.round(1000.0 * RATE)}, FIT, "whole numbers", "--column yaw_rate=gyro_z:mrad/s"
    ),
    "an unknown rate": Case(
        names(rate="foo"), FIT, "no column is recognised as yaw_rate", "--column yaw_rate=COLUMN:deg/s",
        {"COLUMN:deg/s": "foo"},
    ),
    "an unknown torque": Case(
        names(torque="foo"), FIT, "no column is recognised as torque", "--column torque=COLUMN", {"COLUMN": "foo"}
    ),
    "an unknown time": Case(
        {**names(time="foo"), "foo": 1000.0 * T}, FIT, "no column is recognised as the time", "--column t=foo:ms"
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
        {"t": T, **turned_by(MAY, "torque")}, FIT, "count in opposite directions", "--column torque=-torque",
        cures=("sign",),
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
        {"SCALE": "6"}, cures=("scale", "own inertia",)
    ),
    "a torque without its decimal mark": Case(
        {**names(), "tau": np.round(1e4 * TORQUE)}, FIT, "may have lost its decimal mark",
        "--column torque=tau*SCALE", {"SCALE": "0.0001"}, cures=("scale", "own inertia")
    ),
    "milliradians in inspect": Case(
        {**names(), "gyro_z": 1000.0 * RATE}, ("inspect",), "looks like mrad/s", "--column yaw_rate=gyro_z:mrad/s"
    ),
    "a fraction of full thrust": Case(
        {**names(), "tau": TORQUE / 6.0}, (*FIT, "--column", "torque=tau:fraction"), "is a fraction of full thrust",
        "--column 'torque=tau*NEWTON_METRES'", {"NEWTON_METRES": "6"}, drops=("--column", "torque=tau:fraction"),
    ),
    "millimetres": Case(
        {**WHOLE, "surge": 1000.0 * ONE["surge"]}, ("identify",), "beyond the plausible ±60 m/s",
        "--column surge=surge:mm/s",
    ),
    "whole millimetres": Case(
        {**WHOLE, "sway": np.round(1000.0 * ONE["sway"])}, ("identify",), "values of sway are whole numbers",
        "--column sway=sway:mm/s",
    ),
    "fractions of a day": Case(
        {**names(), "time": 0.5 + T / 86_400.0}, FIT, "if it is in d", "--column t=time:d"
    ),
    "minutes": Case({**names(), "time": T / 60.0}, FIT, "is read as s, 1 in all (if min:", "--column t=time:min"),
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
    "an inertia and a mass matrix": Case(
        WHOLE, ("fit", "--inertia", "2", "--set", f"vehicle.mass_matrix={MATRIX}"), "the body that is declared has 2",
        "", cures=("inertia twice",), drops=("--inertia", "2"),
    ),
    "another inertia": Case(
        names(), ("fit", "--inertia", "6"), "the declared inertia needs", "with --inertia", cures=("inertia or scale",),
        drops=("--inertia", "6"), found={"with --inertia": "--inertia 0.6"},
    ),
    "a sign that was assumed": Case(
        {**names(), "tau": -TORQUE}, (*FIT, "--assume-sign"), "count in opposite directions, and no delay",
        "", cures=("sign assumed",), drops=("--assume-sign",), status=2,
    ),
    "radians under a name of degrees": Case(
        {"time": T, "yaw rate (deg/s)": RATE, "tau": TORQUE}, FIT, "as its name says: give",
        "--column 'yaw_rate=yaw rate (deg/s):rad/s'", cures=("radians",),
    ),
    "milliseconds under a name of seconds": Case(
        FINE, FIT, "as if stamps in milliseconds", "--column t=t:ms",
        cures=("milliseconds",),
    ),
    "pulses": Case(
        {**names(), "tau": 1500.0 + 50.0 * TORQUE, "thrust": TORQUE}, FIT, "looks like a servo's pulse",
        "give the moment in N m instead", {"give the moment in N m instead": "--column torque=thrust"}, ("pulses",),
    ),
    "a velocity over several": Case(
        WHOLE, ("fit", "--inertia", "2"), "the axis is coupled to others", "--set vehicle.mass_matrix=…",
        {"…": MATRIX}, ("other velocities",), ("--inertia", "2"),
    ),
    "the sign of one log": Case(
        {"t": T, **turned_by(JUNE, "torque")}, FIT, "june.csv: yaw torque and yaw rate count in opposite",
        "--column june.csv:torque=-torque", cures=("sign of a log",), beside=True,
    ),
    "degrees in one log": Case(
        {"t": T, "yaw_rate": np.degrees(0.4 * JUNE["yaw_rate"]), "torque": 0.4 * JUNE["torque"]},
        (*FIT, "--set", "vehicle.rate_limit=50"), "it looks like degrees per second",
        "--column june.csv:yaw_rate=yaw_rate:deg/s", cures=("degrees",), beside=True,
    ),
    "another unit in one log": Case(
        {"t": T, **JUNE, "torque": JUNE["torque"] / 6.0}, FIT, "as a share of full thrust is",
        "--column june.csv:torque=torque*", {"torque*": "torque*6"}, ("unit of a log",), beside=True,
    ),
    "a late log": Case(
        {"t": T, **JUNE, "torque": late(JUNE["torque"], 2)}, FIT, "the torque is 0.1 s later against the yaw rate",
        "", cures=("delay of a log",), drops=("june.csv",), beside=True,
    ),
    "a narrower filter": Case(
        columns_of(slow(4, 0.05, (0.3, 0.9), 120.0)), (*FIT, "--set", "signals.smoothing=0.2"),
        "the damping curve may be", "--set signals.smoothing=0.0", {"=0.0": "=0.05"},
        cures=("smoothing",), drops=("--set", "signals.smoothing=0.2"),
    ),
    "a command": Case(
        columns_of(slow(13, 0.5)), (*FIT, "--set=signals.torque=measured", "--set=signals.smoothing=0.6"),
        "give --set signals.torque=commanded", "--set signals.torque=commanded",
        cures=("command",), drops=("--set=signals.torque=measured",),
    ),
    **{
        name: Case({"t": WHOLE["t"], **columns}, ("identify",), said, flags, found, (cured,))
        for name, columns, said, flags, found, cured in (
            ("another hand", turned_by(ONE, "sway", "sway_force"), "sway counts in the other direction",
             "--column sway=-sway --column sway_force=-sway_force", {}, "hands"),
            ("another place", at(ONE, 0.4, 0.0), "velocities of a place 0.40 m ahead",
             "--set 'inputs.velocity_place=[0.40, 0.00, 0]'", {}, "place"),
            ("another frame", NORTH, "look like velocities to the north and east",
             "--set inputs.velocity_frame=north_east", {}, "frame"),
            ("a frame of its own", turned_heading(NORTH, 1.2), "of a frame whose north has the heading 69°",
             "--set inputs.velocity_frame=north_east --set inputs.velocity_north=1.2", {}, "frame"),
            ("another frame, and no heading", {**{name: NORTH[name] for name in PLANAR}, "bearing": ONE["heading"]},
             "turned by the integral of the yaw rate", "--column heading=NAME, and give --set inputs.velocity_frame=n",
             {"NAME, and give": "bearing", "=n": "=north_east"}, "frame without heading"),
        )
    },
}  # fmt: skip


def test_every_cure_has_a_case() -> None:
    assert {name for case in CASES.values() for name in case.cures} == CURES.keys()


def said_by(capsys: pytest.CaptureFixture[str]) -> str:
    """What was printed, on one line."""
    return " ".join("".join(capsys.readouterr()).split())


def pattern_of(cure: str) -> str:
    """What a cure of the table looks like in a sentence."""
    return ".*".join(map(re.escape, re.split(r"{.*?}", CURES[cure])))


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] * (case.words == ("identify",))) for name, case in CASES.items()],
)
def test_the_cure_is_tried(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    monkeypatch.chdir(tmp_path)
    case, logs = CASES[name], ["june.csv"]
    if case.beside:
        logs = ["may.csv", "june.csv", "july.csv"]
        for log, columns in (("may.csv", MAY), ("july.csv", JULY)):
            as_csv(Path(log), {"t": T, **columns})
    if isinstance(case.log, list):
        logs = [str(link.as_tlog(Path("log.tlog"), case.log))]
    else:
        as_csv(Path("june.csv"), case.log)
    first, *rest = case.words
    main([first, *logs, *rest])
    said = said_by(capsys)
    assert case.said in said
    assert case.flags in said
    for cure in case.cures:
        assert re.search(pattern_of(cure), said), CURES[cure]
    flags = case.flags
    for known, replaced in case.found.items():
        flags = flags.replace(known, replaced)
    words = [word for word in (*logs, *rest) if word not in case.drops]
    assert main([first, *words, *shlex.split(flags)]) == case.status
    assert case.said not in said_by(capsys)
