"""Tables as people have them: each spelling gives the numbers of the plain table, or its cause is named."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.axes import YAW
from service.inputs.marks import without_marks
from service.inputs.settings import Inputs
from service.logs.reading import LogDescription
from service.recordings.reading import Reading
from service.recordings.recording import Recording, from_table
from service.recordings.samples_from_recording import signals_for
from tests.service.logs.dive import dive, read

DIVE = dive(seconds=20.0)
Spell = Callable[[float], str]


def table(
    header: str, time: Spell, rate: Spell = "{:.9f}".format, torque: Spell = "{:.9f}".format, mark: str = ","
) -> str:
    lines = [header]
    lines += [
        mark.join((time(t), rate(r), torque(u))) for t, r, u in zip(DIVE.time, DIVE.rate, DIVE.torque, strict=True)
    ]
    return "\n".join(lines) + "\n"


def comma(value: float) -> str:
    return f"{value:.9f}".replace(".", ",")


def in_quotes(value: float) -> str:
    return f'"{comma(value)}"'


def dated(spelling: str, begin: datetime) -> Spell:
    return lambda t: (begin + timedelta(seconds=round(t, 3))).strftime(spelling)


def points(value: float) -> str:
    return f"{value:,.0f}".replace(",", ".")


NIGHT = datetime(2024, 2, 13, 23, 59, 50, tzinfo=UTC)
OURS = "t,yaw_rate,torque"
SUMMER_ENDS_S = 10.0


def set_back(t: float) -> str:
    return dated("%Y-%m-%d %H:%M:%S.%f", NIGHT)(t - (3600.0 if t > SUMMER_ENDS_S else 0.0))


PLAIN = table(OURS, "{:.3f}".format)
ROWS_OF_PLAIN = PLAIN.partition("\n")[2]
READ = {
    "day numbers of a spreadsheet": table(OURS, lambda t: f"{45231.5123 + t / 86_400.0:.11f}"),
    "minutes": table("time (min),yaw_rate,torque", lambda t: f"{t / 60.0:.9f}"),
    "seconds and nanoseconds": table(
        "header.stamp.secs,header.stamp.nsecs,yaw_rate,torque", lambda t: f"{int(t)},{round(1e9 * (t % 1.0))}"
    ),
    "the whole table twice": PLAIN + ROWS_OF_PLAIN,
    "the whole table twice, with its header": PLAIN + PLAIN,
    "each row twice": OURS + "\n" + "".join(2 * f"{row}\n" for row in ROWS_OF_PLAIN.splitlines()),
    "the last rows again": PLAIN + "".join(f"{row}\n" for row in ROWS_OF_PLAIN.splitlines()[-90:]),
    "remarks above": "# of a dive\n# in May\n" + table(OURS, "{:.3f}".format),
    "a header that is a remark": table("# t,yaw_rate,torque", "{:.3f}".format),
    "a title above": "Dive 7 in May\n\n" + table(OURS, "{:.3f}".format),
    "units in words": table(f"{OURS}\nseconds,radians per second,N·m", "{:.3f}".format),
    "date as t": table(OURS, dated("%Y-%m-%dT%H:%M:%S.%f", NIGHT)),
    "date under a name of its own": table("logged at,yaw_rate,torque", dated("%Y-%m-%d %H:%M:%S.%f", NIGHT)),
    "day first": table("Zeit;yaw_rate;torque", dated("%d.%m.%Y %H:%M:%S.%f", NIGHT), comma, comma, ";"),
    "month first": table("when,yaw_rate,torque", dated("%m/%d/%Y %H:%M:%S.%f", NIGHT)),
    "past midnight": table("time,yaw_rate,torque", dated("%H:%M:%S.%f", NIGHT)),
    "past noon, of twelve hours": table("time,yaw_rate,torque", dated("%I:%M:%S.%f %p", NIGHT)),
    "past the hour, without hours": table("time,yaw_rate,torque", dated("%M:%S.%f", NIGHT)),
    "since the beginning, with days": table("time,yaw_rate,torque", lambda t: f"0 days 00:00:{t:09.6f}"),
    "date with a comma": table(OURS.replace(",", ";"), lambda t: dated("%Y-%m-%d %H:%M:%S,%f", NIGHT)(t), mark=";"),
    "a spreadsheet's separator": "sep=;\n" + table("t;yaw_rate;torque", comma, comma, comma, ";"),
    "clock set back": table("time,yaw_rate,torque", set_back),
    "clock of t set back": table(OURS, lambda t: f"{t if t < SUMMER_ENDS_S else t - 7.0:.3f}"),
    "commas in quotes": table('"t","yaw_rate","torque"', in_quotes, in_quotes, in_quotes),
    "thousands with points": table("t;yaw_rate;torque", lambda t: points(1e3 * t), comma, comma, ";"),
    "thousands with points, since 1970": table(
        "t;yaw_rate;torque", lambda t: points(1.7e12 + 1e3 * t), comma, comma, ";"
    ),
    "thousands in quotes": table(OURS, lambda t: f'"{1e3 * t:,.0f}"'),
    "thousands with spaces": table(
        "t;yaw_rate;torque", lambda t: points(1e3 * t).replace(".", "\u202f"), comma, comma, ";"
    ),
    "row of units": table(OURS + "\nms,°/s,Nm", lambda t: f"{1e3 * t:.0f}", lambda r: f"{np.degrees(r):.9f}"),
    "row of units in brackets": table(OURS + "\n[s],[deg/s],[N m]", "{:.3f}".format, lambda r: f"{np.degrees(r):.9f}"),
    "units below those of the header": table(
        "t (ms),yaw_rate (deg/s),torque\nms,deg/s,N m", lambda t: f"{1e3 * t:.0f}", lambda r: f"{np.degrees(r):.9f}"
    ),
    "units behind the numbers": table(
        OURS, lambda t: f"{1e3 * t:.0f} ms", lambda r: f"{np.degrees(r):.9f}°/s", "{:.9f} Nm".format
    ),
    "the name of the month": table("time,yaw_rate,torque", dated("%d-%b-%Y %H:%M:%S.%f", NIGHT)),
    "texts beside": table("t,yaw_rate,torque,mode", "{:.3f}".format, torque="{:.9f},MANUAL".format),
    "several rows a stamp": table(OURS, lambda t: f"{int(round(t, 3) + 1.7e9)}"),
}


@pytest.mark.parametrize("name", READ)
def test_it_is_read_as_the_plain_table(tmp_path: Path, name: str) -> None:
    path = tmp_path / "run.csv"
    path.write_text(READ[name], encoding="utf-8")
    recording = Reading(learns=False).of_one(path)
    for stream, values in (("yaw_rate", DIVE.rate), ("torque", DIVE.torque)):
        time, got = recording.streams()[stream]
        np.testing.assert_allclose(got, values, atol=1e-6)
        np.testing.assert_allclose(time - time[0], DIVE.time, atol=1e-5)


@pytest.mark.parametrize("said", ["yaw_rate=gz:deg/s", "yaw_rate=gz"])
def test_a_unit_that_a_person_and_the_table_say_is_used_once(tmp_path: Path, said: str) -> None:
    (tmp_path / "run.csv").write_text(
        table("t,gz,tau\nms,deg/s,N m", lambda t: f"{1e3 * t:.0f}", lambda r: f"{np.degrees(r):.9f}")
    )
    recording = Reading(LogDescription((said, "t=t:ms"), Inputs()), learns=False).of_one(tmp_path / "run.csv")
    np.testing.assert_allclose(recording.streams()["yaw_rate"][1], DIVE.rate, atol=1e-6)


@pytest.mark.parametrize(
    ("text", "cause", "cure"),
    [
        (table("t(msec),yaw_rate,torque", "{:.3f}".format), "the log would last 0.02 s", "t=t(msec):s"),
        (table("time [us],yaw_rate,torque", lambda t: f"{1e3 * t:.0f}"), "if it is in ms", "t=time [us]:ms"),
        (table(OURS, comma, comma, comma), "under a header of 3 look like decimal commas", None),
        (table("time,r,tau", dated("%H:%M:%S.%f", NIGHT), comma, comma), "look like decimal commas", None),
        (table("time,yaw_rate,torque", lambda t: f"T+{t:.3f}"), "'T+0.000', which is read as no time", None),
        (table("time,r,tau", "{:.3f}".format) + "End of file\n", "row 402: 'time' is 'End of file'", None),
        (table("time,r,tau", "{:.3f}".format, lambda r: f"{r:.5f} turns/s"), "turns/s', which is read as no", None),
        (table("time,r,tau", lambda t: f"{1.7e12 + 1e3 * t:.3E}"), "is 1.7e+12 in every row", None),
        (table(OURS, "{:.3f}".format, lambda r: f"{1e6 * r:.0f}"), "whole numbers", "yaw_rate=yaw_rate*0.000001"),
        (table("stamp,r,tau", "{:.3f}".format, lambda r: f"{1e3 * r:.0f}"), "whole numbers", "yaw_rate=r*0.001"),
    ],
)  # fmt: skip
def test_the_cause_is_named_and_its_cure_reads_it(tmp_path: Path, text: str, cause: str, cure: str | None) -> None:
    path = tmp_path / "run.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(BadInput) as caught:
        Reading().of_one(path)
    assert cause in str(caught.value)
    assert "\n" not in str(caught.value)
    if cure is not None:
        np.testing.assert_allclose(read(path, cure).columns["yaw_rate"], DIVE.rate, atol=2e-3)


@pytest.mark.parametrize("encoding", ["utf-16", "cp1252", "utf-8-sig"])
def test_any_encoding_of_text(tmp_path: Path, encoding: str) -> None:
    text = table("time;yaw_rate [°/s];tau", "{:.3f}".format, lambda r: f"{np.degrees(r):.9f}", mark=";")
    (tmp_path / "run.csv").write_text(text, encoding=encoding)
    np.testing.assert_allclose(read(tmp_path / "run.csv").columns["yaw_rate"], DIVE.rate, atol=1e-6)


def test_rows_that_come_again_are_said_and_rows_at_rest_are_none(tmp_path: Path) -> None:
    (tmp_path / "twice.csv").write_text(PLAIN + ROWS_OF_PLAIN, encoding="utf-8")
    assert "400 of 800 rows come again with all their values: taken once" in read(tmp_path / "twice.csv").notes
    still = [f"{int(t)},{r if t > 8.0 else 0.0},{u}" for t, r, u in zip(DIVE.time, DIVE.rate, DIVE.torque, strict=True)]
    (tmp_path / "still.csv").write_text("\n".join(["time,r,tau", *still]), encoding="utf-8")
    recording = read(tmp_path / "still.csv")
    assert recording.time.size == DIVE.time.size
    assert not any("again" in note for note in recording.notes)


def test_rows_of_one_topic_after_another_are_sorted(tmp_path: Path) -> None:
    lines = ["stamp,r,tau", *(f"{t},{r}," for t, r in zip(DIVE.time, DIVE.rate, strict=True))]
    lines += [f"{t},,{u}" for t, u in zip(DIVE.time, DIVE.torque, strict=True)]
    (tmp_path / "run.csv").write_text("\n".join(lines), encoding="utf-8")
    recording = read(tmp_path / "run.csv")
    np.testing.assert_allclose(recording.streams()["torque"][0], DIVE.time)
    assert not any("clock" in note for note in recording.notes)


def test_a_pause_does_not_thin_the_samples() -> None:
    def recording(pause: float) -> Recording:
        time = DIVE.time + pause * (DIVE.time > SUMMER_ENDS_S)
        return from_table("run", time, {"yaw_rate": DIVE.rate, "torque": DIVE.torque})

    periods = [signals_for([recording(pause)], 0.6, YAW.fastest).sample_period for pause in (0.0, 120.0, 36_000.0)]
    np.testing.assert_allclose(periods, periods[0], rtol=0.01)


RATE: Array = np.sin(np.arange(400) * 0.05)


@pytest.mark.parametrize(
    ("mark", "is_command", "left_out"),
    [
        (-32.768, False, True), (327.67, True, True), (-9999.0, True, True), (65.535, False, True),
        (100.25, False, True), (100.25, True, False), (3.0, False, False),
    ],
)  # fmt: skip
def test_marks_of_no_measurement_are_left_out(mark: float, is_command: bool, left_out: bool) -> None:
    values = np.where(np.arange(400) % 50 < 3, mark, RATE)
    found, note = without_marks("surge", values, is_command)
    assert (note is not None) == left_out
    assert np.isnan(found).sum() == left_out * np.count_nonzero(values == mark)
    pulses = np.where(np.arange(400) % 50 < 3, 40.0, 0.0)
    assert without_marks("torque", pulses, True)[1] is None
    assert without_marks("surge", RATE)[1] is None


def test_zeros_of_a_doppler_log_without_bottom_are_left_out() -> None:
    lost = np.arange(400) % 50 < 7
    found, note = without_marks("surge", np.where(lost, 0.0, RATE))
    assert note is not None
    assert note.startswith("surge drops to exactly 0 in 56 of 400 samples")
    np.testing.assert_array_equal(np.isnan(found), lost)
    still = np.where(np.sin(np.arange(400) * 0.02) < 0.0, 0.0, RATE)  # at rest by turns
    for sound in (still, np.round(RATE, 1), np.where(RATE > 0.0, RATE, 0.0), np.where(np.arange(400) < 90, 0.0, RATE)):
        assert without_marks("surge", sound)[1] is None
    assert without_marks("voltage", np.where(lost, 0.0, RATE))[1] is None
