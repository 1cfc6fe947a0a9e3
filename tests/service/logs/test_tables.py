"""Tables: CSV of any delimiter, by hand, and Parquet by pyarrow."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from incsvr.errors import BadInput
from service.recordings.recording import Recording
from tests.service.logs.dive import dive, read

DIVE = dive(seconds=10.0)


def rows(stamps: list[str], delimiter: str = ",", point: str = ".", scale: float = 1.0) -> str:
    """A table with a stamp, a rate and a torque under names of other people."""
    lines = [delimiter.join(["stamp", "r", "tau"])]
    for stamp, rate, torque in zip(stamps, DIVE.rate, DIVE.torque, strict=True):
        lines.append(delimiter.join([stamp, *(f"{x:.9f}".replace(".", point) for x in (scale * rate, torque))]))
    return "\n".join(lines) + "\n"


def same(recording: Recording, begin: float = 0.0, within: float = 1e-6) -> None:
    for name, values in (("yaw_rate", DIVE.rate), ("torque", DIVE.torque)):
        time, got = recording.streams()[name]
        np.testing.assert_allclose(time - begin, DIVE.time, atol=within)
        np.testing.assert_allclose(got, values, atol=1e-8)


@pytest.mark.parametrize(
    ("delimiter", "point"), [(";", ","), (";", "."), ("\t", "."), ("|", "."), (" ", "."), (",", ".")]
)
def test_any_delimiter(tmp_path: Path, delimiter: str, point: str) -> None:
    path = tmp_path / "run.txt"
    path.write_text(rows([f"{t:.3f}".replace(".", point) for t in DIVE.time], delimiter, point), encoding="utf-8")
    same(read(path))


@pytest.mark.parametrize(
    ("times", "unit", "begin"),
    [(1e3, "ms", 0.0), (1e6, "us", 0.0), (1e9, "ns", 0.0), (1.0, "s", 1.7e9), (1e3, "ms", 1.7e9), (1e9, "ns", 1.7e9)],
)
def test_stamps_in_any_unit_since_boot_or_since_1970(tmp_path: Path, times: float, unit: str, begin: float) -> None:
    path = tmp_path / "run.csv"
    path.write_text(rows([f"{round((begin + t) * times)}" if times > 1 else f"{begin + t:.3f}" for t in DIVE.time]))
    for said in ("t=stamp", f"t=stamp:{unit}"):  # told by their steps and size, and said
        same(read(path, said), begin, within=2e-6)


def test_instants_of_iso_8601(tmp_path: Path) -> None:
    from datetime import UTC, datetime

    for zone, end in ((UTC, "+00:00"), (None, "")):
        stamps = [datetime.fromtimestamp(1.7e9 + t, UTC).replace(tzinfo=zone).isoformat() for t in DIVE.time]
        assert stamps[1].endswith(end)
        path = tmp_path / "run.csv"
        path.write_text(rows(stamps), encoding="utf-8")
        same(read(path), 1.7e9, within=2e-6)


def test_units_signs_and_factors_are_said(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    path.write_text(rows([f"{t}" for t in DIVE.time], scale=-180.0 / np.pi), encoding="utf-8")
    same(read(path, "yaw_rate=-r:deg/s", "torque=tau", "t=stamp"))
    doubled = read(path, "yaw_rate=-r*2:deg/s", "torque=tau").columns["yaw_rate"]
    np.testing.assert_allclose(doubled, 2.0 * DIVE.rate, atol=1e-7)


def test_columns_that_are_named_keep_the_table_s_own_time(tmp_path: Path) -> None:
    """Also where no other name of the table is recognised."""
    path = tmp_path / "dive.csv"
    path.write_text("t,turn,pull\n" + "".join(f"{0.1 * k:.1f},{k % 5},{k % 7}\n" for k in range(50)), encoding="utf-8")
    np.testing.assert_allclose(read(path, "yaw_rate=turn", "torque=pull", learns=False).time, 0.1 * np.arange(50))


def test_units_stand_in_the_names(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    text = rows([f"{1000 * t:.0f}" for t in DIVE.time], scale=180.0 / np.pi)
    path.write_text(text.replace("stamp,r,tau", "time [ms],Yaw rate (deg/s),torque_nm"), encoding="utf-8")
    same(read(path))


def test_rows_of_one_instant_are_merged_and_gzip_is_inflated(tmp_path: Path) -> None:
    lines = ["stamp,r,tau"]
    for t, rate, torque in zip(DIVE.time, DIVE.rate, DIVE.torque, strict=True):
        lines += [f"{t},{float(rate)!r},", f"{t},,{float(torque)!r}"]
    path = tmp_path / "run.csv.gz"
    path.write_bytes(gzip.compress("\n".join(lines).encode()))
    same(read(path))


def test_parquet(tmp_path: Path) -> None:
    path = tmp_path / "run.data"
    stamps = pa.array(np.round((1.7e9 + DIVE.time) * 1e6).astype(np.int64), pa.timestamp("us", "UTC"))
    nested = pa.StructArray.from_arrays([pa.array(DIVE.rate), pa.array(DIVE.rate)], ["x", "z"])
    columns = {"time": stamps, "angular_velocity": nested, "torque": pa.array(DIVE.torque, pa.float64())}
    pq.write_table(pa.table({**columns, "mode": ["manual"] * DIVE.time.size}), path)
    same(read(path), 1.7e9, within=2e-6)


@pytest.mark.parametrize(
    ("text", "columns", "sentence"),
    [
        (
            "a,b,c\n0,1,2\n1,2,3\n",
            (),
            "no column is recognised as yaw_rate among a, b, c; name it: --column",
        ),
        ("a,b,c\n0,1,2\n1,2,3\n", ("yaw_rate=b", "torque=c"), "no column is recognised as the time"),
        ("a,b,c\n0,1,2\n1,2,3\n", ("yaw_rate=d",), "there is no d"),
        ("stamp,rate_r,c\n0,1,2\n1,2,3\n", ("yaw_rate=rate",), "did you mean rate_r?"),
        ("a,b,c\n0,1,2\n1,2,3\n", ("yaw_rate=b:mph",), "there is no unit 'mph'; known are rad/s"),
        ("a,b,c\n0,1,2\n1,2,3\n", ("yaw_rate",), "write NAME=FIELD"),
        (
            "t,r,torque\n0,20,2\n1,20,3\n",
            (),
            "yaw_rate is 20 at 0 s, beyond the plausible ±6 rad/s; if it is in degrees",
        ),
        ("t;r;torque\n", (), "there are no rows below the header"),
        ("", (), "the file is empty"),
        ("name,remark\nhello,world\nfoo,bar\n", (), "no column of it holds numbers (only texts: name, remark)"),
        ("0;1;2\n0;1;2\n", (), "the header is missing"),
    ],
)
def test_what_is_wrong_is_said_with_its_cure(
    tmp_path: Path, text: str, columns: tuple[str, ...], sentence: str
) -> None:
    path = tmp_path / "run.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(BadInput) as caught:
        read(path, *columns)
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)


def test_disarmed_is_not_learned(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    lines = ["t,yaw_rate,torque,armed"]
    for t, rate, torque in zip(DIVE.time, DIVE.rate, DIVE.torque, strict=True):
        lines.append(f"{t},{rate},{torque},{int(t > 4.0)}")
    path.write_text("\n".join(lines), encoding="utf-8")
    recording = read(path)
    assert recording.time[0] == pytest.approx(4.05)
    assert "armed" not in recording.columns
    assert recording.notes == ("armed for 5.9 of 9.95 s; the rest is left out",)
    assert "armed" in read(path, learns=False).columns
    path.write_text("\n".join(line.rpartition(",")[0] + ",0" if k else line for k, line in enumerate(lines)))
    with pytest.raises(BadInput, match="the vehicle was never armed, so there is nothing to learn from"):
        read(path)
