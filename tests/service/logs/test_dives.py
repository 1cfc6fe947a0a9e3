"""Several files of one dive, or its folder, are one recording: the same as the log that was never parted."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from service.recordings.reading import Reading
from service.recordings.recording import Recording
from tests.service import link
from tests.service.logs.dive import dive, refused

DIVE = dive(40.0)
SAID = link.in_order(link.parameters(), link.swum(DIVE))
HALF = 20.0


def halves(said: list[link.Said]) -> tuple[list[link.Said], list[link.Said]]:
    return [each for each in said if each.at < HALF], [each for each in said if each.at >= HALF]


def as_csv(path: Path, inside: Any, start: float = 0.0, names: str = "t,yaw_rate,torque") -> Path:
    rows = zip(
        (start + DIVE.time[inside]).tolist(), DIVE.rate[inside].tolist(), DIVE.torque[inside].tolist(), strict=True
    )
    path.write_text(f"{names}\n" + "".join(f"{t!r},{r!r},{tau!r}\n" for t, r, tau in rows), encoding="utf-8")
    return path


def same(found: Recording, whole: Recording) -> None:
    np.testing.assert_array_equal(found.time, whole.time)
    assert list(found.columns) == list(whole.columns)
    for name, values in whole.columns.items():
        np.testing.assert_array_equal(found.columns[name], values)


@pytest.mark.slow
@pytest.mark.parametrize("form", link.WRITERS)
def test_parts_are_the_whole(tmp_path: Path, form: str) -> None:
    """By name and as a folder, in whatever order: parameters and arming of the first part hold in the second one."""
    folder = tmp_path / "parts"
    folder.mkdir()
    whole = link.WRITERS[form](tmp_path / f"whole.{form}", SAID)
    first, second = halves(SAID)
    parts = [link.WRITERS[form](folder / f"{name}.{form}", said) for name, said in (("b", first), ("a", second))]
    (folder / "notes.txt").write_text("the second dive of the day\n", encoding="utf-8")
    reading = Reading()
    (wanted,) = reading.of_all([whole])
    for given in ([folder], parts, parts[::-1]):
        (found,) = reading.of_all(given)
        same(found, wanted)
        assert found.notes[0] == f"read as one log, in the order of time: b.{form}, a.{form}"


@pytest.mark.parametrize("names", ["t,yaw_rate,torque", "stamp,gyro_r,tau"])
def test_parts_of_tables_are_the_whole(tmp_path: Path, names: str) -> None:
    folder = tmp_path / "parts"
    folder.mkdir()
    late = DIVE.time >= HALF
    whole = as_csv(tmp_path / "whole.csv", DIVE.time >= 0.0, names=names)
    parts = [as_csv(folder / "2.csv", ~late, names=names), as_csv(folder / "1.csv", late, names=names)]
    reading = Reading()
    if names.startswith("stamp"):
        columns = ("yaw_rate=gyro_r", "torque=tau", "t=stamp")
        reading = Reading(reading.description.__class__(columns, reading.description.inputs))
    (wanted,) = reading.of_all([whole])
    for given in ([folder], parts):
        (found,) = reading.of_all(given)
        same(found, wanted)


def test_files_that_do_not_go_on_are_runs_of_their_own(tmp_path: Path) -> None:
    """Both begin at zero, as runs do that were cut apart; and an hour later is another dive."""
    runs = [as_csv(tmp_path / f"{name}.csv", DIVE.time < end) for name, end in (("b", 30.0), ("a", 40.0))]
    assert [run.name for run in Reading().of_all(runs)] == ["b.csv", "a.csv"]
    later = as_csv(tmp_path / "later.csv", DIVE.time >= 0.0, start=3600.0)
    assert [run.name for run in Reading().of_all([later, runs[1]])] == ["later.csv", "a.csv"]


def test_the_vehicle_is_chosen_over_all_parts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Vehicle 2 alone moves in the first part, unarmed; vehicle 1 dives in the second one, and both are heard."""
    first, second = halves(link.in_order(link.swum(DIVE)))
    idle = list(link.of(2, link.swum(DIVE, armed_from=1e3)))
    busy = link.in_order(link.parameters(), second)
    one = link.as_tlog(tmp_path / "1.tlog", link.in_order(link.parameters(), first, halves(link.in_order(idle))[0]))
    two = link.as_tlog(tmp_path / "2.tlog", link.in_order(busy, halves(link.in_order(idle))[1]))
    (found,) = Reading().of_all([two, one])
    assert any("vehicle 1 is used" in note for note in found.notes)
    assert found.time[-1] - found.time[0] > 30.0
    other = link.as_tlog(tmp_path / "other.tlog", link.of(2, second))
    said = refused(capsys, "fit", str(one), str(other), "--inertia", "0.6")
    assert "other.tlog: this part has no data of vehicle 1, which is used, but of vehicle 2" in said


def test_a_folder_that_is_no_dive_says_why(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    overlapping, mixed, empty = (tmp_path / name for name in ("overlapping", "mixed", "empty"))
    for folder in (overlapping, mixed, empty):
        folder.mkdir()
    as_csv(overlapping / "a.csv", DIVE.time < 30.0)
    as_csv(overlapping / "b.csv", DIVE.time < 40.0)
    as_csv(mixed / "a.csv", DIVE.time < 30.0)
    link.as_tlog(mixed / "b.tlog", SAID)
    (empty / "README.txt").write_text("nothing yet\n", encoding="utf-8")
    for words in (["inspect"], ["fit", "--inertia", "0.6"], ["trace", "--inertia", "0.6"]):
        said = refused(capsys, words[0], str(overlapping), *words[1:])
        assert "a.csv (0 to 29.95 s) and b.csv (0 to 39.95 s) overlap in time" in said
        assert "logs of several kinds (CSV, MAVLink telemetry)" in refused(capsys, words[0], str(mixed), *words[1:])
        assert "no file in this folder is a log" in refused(capsys, words[0], str(empty), *words[1:])
    both = [str(overlapping / name) for name in ("a.csv", "b.csv")]
    assert "are no parts of one dive" in refused(capsys, "inspect", *both)
