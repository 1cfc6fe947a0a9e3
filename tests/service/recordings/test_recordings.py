"""Recordings: exact there and back, and every fault named with file, row and cure."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from incsvr.errors import BadInput
from incsvr.signals import RUN_PAUSE_S, SignalSettings, synchronise
from service.config.configuration import Config
from service.recordings.reading import Reading, read
from service.recordings.recording import Recording, from_table, sequence
from service.recordings.recording_csv import write
from service.recordings.validation import read_validation
from simulator import leng
from tests.service.conftest import cut

GOOD = "t,yaw_rate,torque\n0.0,0.01,1.0\n0.1,0.02,1.5\n0.2,0.03,2.0\n"


def save(folder: Path, text: str) -> Path:
    path = folder / "run.csv"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("empty", ["", "nan", "NaN", "NA"])
def test_streams_of_different_rates_fit_in_one_file(tmp_path: Path, empty: str) -> None:
    text = "t,torque,yaw_rate,depth\n0,1,0.1,-\n0.5,-,0.2,3.5\n1,2,0.3,-\n\n"
    run = read(save(tmp_path, text.replace("-", empty)))
    assert run.channels == ("depth",)
    streams = run.streams()
    np.testing.assert_array_equal(streams["torque"], ([0.0, 1.0], [1.0, 2.0]))
    np.testing.assert_array_equal(streams["yaw_rate"], ([0.0, 0.5, 1.0], [0.1, 0.2, 0.3]))
    np.testing.assert_array_equal(streams["depth"], ([0.5], [3.5]))


@given(
    st.lists(st.integers(0, 1_900_000_000).map(lambda count: 1e-9 * count), min_size=1, max_size=30, unique=True),
    st.data(),
)
def test_what_is_written_is_read_to_the_last_bit(times: list[float], data: st.DataObject) -> None:
    cell = st.one_of(st.just(float("nan")), st.floats(-6.0, 6.0))
    columns = {
        name: np.array([0.0, *data.draw(st.lists(cell, min_size=len(times) - 1, max_size=len(times) - 1))])
        for name in ("yaw_rate", "torque", "depth")
    }
    run = from_table("run.csv", np.array(sorted(times)), columns)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.csv"
        write(path, run)
        again = read(path)
    assert again.name == run.name
    for name, (stamps, values) in run.streams().items():
        found = again.streams()[name]
        assert (found[0].tobytes(), found[1].tobytes()) == (stamps.tobytes(), values.tobytes())


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "run.csv: the file is empty; a log begins with a header"),
        ("\n\n", "the file is empty"),
        ("t,yaw_rate,torque\n", "there are no rows below the header"),
        ("t,yaw_rate\n0,1\n", "no column is recognised as torque among t, yaw_rate; name it"),
        ("when,yaw_rate,torque\n0,1,1\n", "no column is recognised as the time; name it"),
        ("t,yaw_rate,torque,torque\n0,1,1,1\n", "row 1: column 4 is named 'torque'"),
        (GOOD + "0.3,0.1\n", "row 5: 2 cells under a header of 3"),
        (GOOD + "0.3,0.1,1,1\n", "row 5: 4 cells under a header of 3"),
        (GOOD + "0.3,fast,1\n", "row 5: yaw_rate is 'fast', which is no number"),
        (GOOD + "0.3,inf,1\n", "row 5: yaw_rate is 'inf'; leave the cell empty"),
        (GOOD + "0.3,0.1,-inf\n", "row 5: torque is '-inf'; leave the cell empty"),
        (GOOD + "inf,0.1,1\n", "row 5: t is 'inf'"),
        (GOOD + ",0.1,1\n", "row 5: t is empty; every row needs its time"),
        (GOOD + "0.2,0.1,1\n", "t is 0.2 in several rows, with different values of yaw_rate; leave one of them"),
        (GOOD + "0.15,0.1,1\n", "row 5: time runs backwards, from 0.2 to 0.15 s; sort the rows"),
        ("t,yaw_rate,torque\n-1,0,0\n", "row 2: t is -1; let time begin at zero"),
        (GOOD + "0.3,14.3,1\n", "row 5: yaw_rate is 14.3, beyond the plausible ±6 rad/s; if it is in degrees"),
        ("t,yaw_rate,torque\n0,0,0\n20,0,0\n40,0,0\n", "t advances by 20 in a typical row; if the stamps are milli"),
        ("t,yaw_rate,torque\n0,0.1,\n0.1,0.1,\n", "the column torque is empty"),
        ("t,yaw_rate,torque\n1e12,0,0\n", "row 2: t is 1e+12, which is no time in seconds"),
    ],
)
def test_a_fault_is_named_with_its_row_and_its_cure(tmp_path: Path, text: str, message: str) -> None:
    path = save(tmp_path, text)
    with pytest.raises(BadInput) as caught:
        read(path)
    assert message in str(caught.value)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


@given(
    st.one_of(
        st.binary(max_size=200),
        st.text(max_size=200).map(str.encode),
        st.lists(
            st.lists(st.sampled_from(["", "0", "1e999", "nan", "-1", "x", '"', "0.5", "1e300"]), max_size=4), max_size=6
        )
        .map(lambda rows: "t,yaw_rate,torque\n" + "\n".join(",".join(row) for row in rows))
        .map(str.encode),
    )
)
def test_no_bytes_bring_it_down(content: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.csv"
        path.write_bytes(content)
        try:
            run = read(path)
        except BadInput as error:
            assert str(error).startswith(str(path))  # noqa: PT017 - or it is a recording, which is as good
        else:
            assert np.isfinite(run.time).all()


def test_what_is_no_file_or_no_text_is_named(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="there is no such file"):
        read(tmp_path / "missing.csv")
    with pytest.raises(BadInput, match="cannot be read"):
        read(tmp_path)
    binary = tmp_path / "binary.csv"
    binary.write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(BadInput, match="export it as CSV"):
        read(binary)


def test_no_sample_reaches_across_two_runs() -> None:
    time = np.arange(0.0, 10.0, 0.05, dtype=np.float64)
    run = Recording("run", {"yaw_rate": (time, np.full(200, 0.1)), "torque": (time + 0.01, np.full(200, 40.0))})
    other = Recording("other", {**run.streams(), "depth": (time, time)})
    joined = sequence([run, other])
    assert joined.channels == ("depth",)
    assert (np.diff(joined.time) > 0.0).all()
    settings = SignalSettings()
    alone = len(synchronise(settings, run.streams())[0])
    samples, rejected = synchronise(settings, joined.streams())
    assert not rejected
    assert np.diff(samples.time).max() > RUN_PAUSE_S
    assert abs(len(samples) - 2 * alone) <= 2  # the grid falls otherwise into the second run, and it lacks a successor


def test_only_a_limit_that_can_be_raised_is_named(tmp_path: Path) -> None:
    path = save(tmp_path, GOOD + "0.3,14.3,1\n")
    with pytest.raises(BadInput) as caught:
        read(path)
    assert "raise" not in str(caught.value)
    with pytest.raises(BadInput, match="turns so fast, raise vehicle"):
        Reading(limit_is="vehicle.rate_limit").of_one(path)


def test_values_of_one_stream_are_a_nanosecond_apart(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=r"the times of torque: 0\.0 and 5e-324 s are less than a nanosecond apart"):
        read(save(tmp_path, "t,yaw_rate,torque\n0,0.1,1\n5e-324,,2\n1,0.2,3\n"))
    assert read(save(tmp_path, "t,yaw_rate,torque\n0,0.1,\n5e-324,,2\n1,0.2,3\n")).time.size == 3


def test_rows_of_one_instant_are_merged(tmp_path: Path) -> None:
    """As where two topics were joined, one row for each."""
    apart = read(save(tmp_path, "t,yaw_rate,torque\n0,0.1,\n0,,1\n0.1,0.2,\n0.1,,2\n0.1,0.2,\n0.2,0.3,3\n"))
    assert apart.time.tolist() == [0.0, 0.1, 0.2]
    assert apart.columns["yaw_rate"].tolist() == [0.1, 0.2, 0.3]
    assert apart.columns["torque"].tolist() == [1.0, 2.0, 3.0]


SOURCES = {"yaw_rate": {"topic": "rows", "field": "r", "unit": "deg/s"}, "torque": {"topic": "rows", "field": "tau"}}


def test_a_log_of_others_gives_the_same_samples(tmp_path: Path) -> None:
    """Semicolons, degrees and other names, which the configured inputs describe; our own needs no description."""
    run, config = cut(leng.recording("V1", seed=7), 60.0), Config.model_validate({"inputs": SOURCES})
    write(tmp_path / "V1.csv", run)
    degrees, torque = np.degrees(run.columns["yaw_rate"]), run.columns["torque"]
    rows = zip(run.time.tolist(), degrees.tolist(), torque.tolist(), strict=True)
    lines = (";".join("" if np.isnan(value) else f"{value:.17g}" for value in row) for row in rows)
    (tmp_path / "dive.csv").write_text("\n".join(("Time (s);r;tau", *lines)), encoding="utf-8")
    own, others = (read_validation(tmp_path / name, config) for name in ("V1.csv", "dive.csv"))
    assert len(own) == len(others) > 50
    np.testing.assert_allclose(others.damping, own.damping, rtol=1e-9)
    np.testing.assert_array_equal(own.damping, leng.samples(run).damping)


def test_what_is_no_log_or_lacks_a_channel_is_one_sentence(tmp_path: Path) -> None:
    run = cut(leng.recording("V1", seed=7), 60.0)
    write(tmp_path / "V1.csv", run)
    config = Config.model_validate({"learner": {"inputs": ["yaw_rate", "surge"]}})
    with pytest.raises(BadInput, match="no channel surge, which every sample needs"):
        read_validation(tmp_path / "V1.csv", config)
    with pytest.raises(BadInput, match="nowhere"):
        read_validation(tmp_path / "nowhere.csv", Config())
