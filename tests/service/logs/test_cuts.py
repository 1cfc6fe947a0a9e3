"""`--from` and `--to`: a log of any format is cut by its own seconds or by the time of day."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from service.cli.command_line import main
from service.logs.cutting import Cut, EmptyCut, instant, since_1970
from service.recordings.archive_reader import ArchiveReader
from service.recordings.reading import read
from service.recordings.recording import Recording, from_table
from service.recordings.recording_csv import write
from tests.service import link
from tests.service.logs.dive import BOOT, dive, refused

DIVE = dive(40.0)
SAID = link.in_order(link.parameters(), link.swum(DIVE))
BEGIN = "22:13:20"
"""The time of day at which the logs begin: EPOCH, in UTC."""


@pytest.fixture
def own(tmp_path: Path) -> Path:
    """A recording of ours that says only once that the vehicle was armed, and holds a wild value at its beginning."""
    rate = DIVE.rate.copy()
    rate[3] = 97.0
    armed = np.full(DIVE.time.size, np.nan)
    armed[0] = 1.0
    path = tmp_path / "own.csv"
    write(path, from_table("own", DIVE.time, {"yaw_rate": rate, "torque": DIVE.torque, "armed": armed}))
    return path


def converted(folder: Path, *words: str) -> Recording:
    out = folder / "out.csv"
    assert main(["convert", words[0], str(out), *words[1:]]) == 0
    return read(out)


@pytest.mark.parametrize("form", link.WRITERS)
def test_a_cut_keeps_the_stamps_and_what_was_said_before_it(tmp_path: Path, form: str) -> None:
    """Parameters and arming were told before the cut, and hold in it."""
    path = link.WRITERS[form](tmp_path / f"dive.{form}", SAID)
    whole = converted(tmp_path, str(path))
    cut = ("--from", f"{BOOT + 10}", "--to", f"{BOOT + 20}")
    part = converted(tmp_path, str(path), *cut)
    kept = (whole.time >= BOOT + 10.0) & (whole.time <= BOOT + 20.0)
    np.testing.assert_array_equal(part.time, whole.time[kept])
    for name, values in part.columns.items():
        np.testing.assert_array_equal(values, whole.columns[name][kept])
    assert np.nanmin(part.columns["armed"]) == 1.0
    assert main(["inspect", str(path), *cut, "--json", str(tmp_path / "inspected.json")]) == 0
    found = json.loads((tmp_path / "inspected.json").read_text(encoding="utf-8"))
    rates = next(each for each in found["streams"] if each["name"].endswith(("ATTITUDE", "IMU")))
    assert rates["count"] == pytest.approx(201, abs=2)
    assert found["measured"]["yaw_rate"]["count"] == pytest.approx(201, abs=1)


@pytest.mark.parametrize("form", ["tlog", "mcap"])
def test_a_time_of_day_is_the_walls(tmp_path: Path, form: str) -> None:
    path = link.WRITERS[form](tmp_path / f"dive.{form}", SAID)
    part = converted(tmp_path, str(path), "--from", "22:13:30", "--to", "22:13:40")
    assert part.time[0] == pytest.approx(BOOT + 10.0, abs=0.1)
    assert part.time[-1] == pytest.approx(BOOT + 20.0, abs=0.1)
    assert converted(tmp_path, str(path), "--from", "22:13").time.size > part.time.size


def test_a_cut_across_midnight(tmp_path: Path) -> None:
    """The log continues from 23:59:50 to 00:00:30."""
    path = tmp_path / "night.csv"
    midnight = 1_700_006_400.0
    rows = zip((midnight - 10.0 + DIVE.time).tolist(), DIVE.rate.tolist(), DIVE.torque.tolist(), strict=True)
    path.write_text("time,r,tau\n" + "".join(f"{t:.2f},{r},{tau}\n" for t, r, tau in rows), encoding="utf-8")
    part = converted(tmp_path, str(path), "--from", "23:59:55", "--to", "00:00:10")
    assert (part.time[0] - midnight, part.time[-1] - midnight) == (-5.0, 10.0)
    late = converted(tmp_path, str(path), "--from", "00:00:05")
    assert late.time[0] - midnight == 5.0
    # stamps since 1970: seconds count from the beginning of the log
    seconds = converted(tmp_path, str(path), "--from", "5", "--to", "20")
    np.testing.assert_array_equal(seconds.time, part.time)


def test_a_cut_that_holds_nothing_says_what_the_log_spans(
    tmp_path: Path, own: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    tlog, out = link.as_tlog(tmp_path / "dive.tlog", SAID), str(tmp_path / "out.csv")
    assert "comes after" in refused(capsys, "convert", str(own), out, "--from", "20", "--to", "10")
    assert "this log does not know the time of day 12:00" in refused(capsys, "inspect", str(own), "--from", "12:00")
    for words in (["inspect", str(tlog)], ["fit", str(tlog), "--inertia", "0.6"], ["replay", str(tlog)]):
        said = refused(capsys, *words, "--from", "500")
        assert "--from 500 selects no data of this log, which spans 21" in said
        assert f" to {BOOT + 39.95:g} s" in said
        assert f"({BEGIN} to 22:13:59 UTC)" in said
        assert "dive.tlog" in said
    assert "spans 0 to 39.95 s" in refused(capsys, "fit", str(own), "--inertia", "0.6", "--from", "40", "--to", "50")


def test_what_is_wrong_outside_the_cut_does_not_matter(
    tmp_path: Path, own: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A gyro that is switched on at the surface shows wild values, and the one word of the arming lies before."""
    out = str(tmp_path / "out.csv")
    assert "row 5: yaw_rate is 97" in refused(capsys, "convert", str(own), out)
    part = converted(tmp_path, str(own), "--from", "1")
    assert part.time[0] == 1.0
    assert part.columns["armed"][0] == 1.0


def test_an_archive_is_cut_by_when_its_messages_came() -> None:
    send = np.asarray(1_700_000_000.0 + np.arange(60.0), dtype=np.float64)
    payloads = [b"%d" % k for k in range(60)]
    kept = ArchiveReader("archive", "yaw", ("rate",), ("json",), np.zeros(60, dtype=np.intp), send, payloads)
    for begin, end in (("10", "20"), ("22:13:30", "22:13:40")):
        part = kept.within(Cut(instant(begin), instant(end)))
        assert list(part.payloads) == payloads[10:21]
        np.testing.assert_array_equal(part.send, send[10:21])
    with pytest.raises(EmptyCut, match="spans 0 to 59 s"):
        kept.within(Cut(instant("100")))
    assert kept.within(Cut()) is kept


def test_stamps_of_no_calendar_know_no_time_of_day() -> None:
    assert since_1970(np.array([1.7e9, 1.7e9 + 1.0]), None) == 0.0
    assert since_1970(np.array([1e16, 1e16 + 2.0]), None) is None
