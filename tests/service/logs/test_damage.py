"""Bags with messages that end early, files that do, and stamps that nobody set: left out, counted, said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mcap.writer import Writer

from incsvr.errors import BadInput
from tests.service import link
from tests.service.logs.dive import EPOCH, read
from tests.service.logs.test_middleware import DIVE, dive_bag, same
from tests.service.logs.test_whose import DIVE as SWUM
from tests.service.logs.test_whose import written

ATTITUDE = 30
"""The number of MAVLink's message."""
FORMS = ("sqlite3", "mcap", "ros1")


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("short", [range(7, 9), range(1)], ids=["some", "first"])
def test_a_short_message_is_left_out_and_counted(tmp_path: Path, form: str, short: range) -> None:
    recording = read(dive_bag(tmp_path, form, short=short))
    time, rate = recording.streams()["yaw_rate"]
    np.testing.assert_allclose(rate, np.delete(DIVE.rate, list(short)), atol=1e-9)
    assert time.size == DIVE.time.size - len(short)
    assert any(f"{len(short)} of {DIVE.time.size} messages of /imu/data cannot" in note for note in recording.notes)


@pytest.mark.parametrize("form", FORMS)
def test_a_bag_of_which_most_cannot_be_read_is_refused_in_a_sentence(tmp_path: Path, form: str) -> None:
    with pytest.raises(BadInput, match=r"messages of /imu/data cannot be read .*: record again"):
        read(dive_bag(tmp_path, form, short=range(1, DIVE.time.size)))


def test_a_file_that_ends_early_says_where(tmp_path: Path) -> None:
    half = link.as_mcap(tmp_path / "half.mcap", link.in_order(link.parameters(), link.swum(DIVE, armed_from=0.0)))
    whole = half.read_bytes()
    half.write_bytes(whole[: len(whole) // 2])
    recording = read(half)
    time = recording.streams()["yaw_rate"][0]
    lasted = time[-1] - time[0]
    (said,) = [note for note in recording.notes if "ends early" in note]
    after = float(said.split("ends early, ")[1].split(" s ")[0])
    assert after == pytest.approx(lasted, abs=0.3)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("unset", [range(5), range(3, 150, 10), range(DIVE.time.size)], ids=["first", "some", "all"])
def test_a_stamp_of_zero_is_none(tmp_path: Path, form: str, unset: range) -> None:
    stamps = np.where(np.isin(np.arange(DIVE.time.size), unset), 0.0, EPOCH + DIVE.time)
    recording = read(dive_bag(tmp_path, form, stamps=stamps))
    same(recording, EPOCH)
    said = [note for note in recording.notes if "messages of /imu/data have no stamp" in note]
    assert bool(said) == (len(unset) < DIVE.time.size)


def test_a_telemetry_log_counts_its_damaged_packets_and_where_it_ends(tmp_path: Path) -> None:
    path = written(tmp_path, "tlog", link.parameters(), link.swum(SWUM, armed_from=0.0))
    whole = read(path).streams()["yaw_rate"][0].size
    content = bytearray(path.read_bytes())
    place = content.index(b"\xfd", len(content) // 2)
    while content[place + 7] != ATTITUDE:
        place = content.index(b"\xfd", place + 1)
    content[place + 15] ^= 0x55
    path.write_bytes(content[:-20])
    recording = read(path)
    assert recording.streams()["yaw_rate"][0].size == whole - 1
    assert any("1 of " in note and "messages of the link cannot be read" in note for note in recording.notes)
    assert any("bytes of the file belong to no whole message" in note for note in recording.notes)


def test_a_dataflash_log_counts_the_bytes_that_it_lost(tmp_path: Path) -> None:
    path = written(tmp_path, "BIN", link.parameters(), link.swum(SWUM))
    whole = read(path)
    assert not any("bytes" in note for note in whole.notes)
    content = bytearray(path.read_bytes())
    middle = content.index(b"\xa3\x95", len(content) // 2)
    path.write_bytes(content[:middle] + b"\x00" * 333 + content[middle:])
    recording = read(path)
    assert any("333 bytes of the file belong to no whole message" in note for note in recording.notes)
    lost = whole.streams()["yaw_rate"][0].size - recording.streams()["yaw_rate"][0].size
    assert 0 <= lost <= 1


def test_messages_in_json_that_end_early_are_counted(tmp_path: Path) -> None:
    said = link.in_order(link.parameters(), link.swum(SWUM, armed_from=0.0))
    path = written(tmp_path, "mcap", said)
    whole = read(path).streams()["yaw_rate"][0].size
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        channels: dict[str, int] = {}
        for k, (each, (key, payload)) in enumerate(zip(said, link.as_keys(said), strict=True)):
            if key not in channels:
                channels[key] = writer.register_channel(key, "json", 0)
            short = payload[: len(payload) // 2] if k % 50 == 49 else payload
            writer.add_message(channels[key], round(1e9 * (EPOCH + each.at)), short, 0)
        writer.finish()  # type: ignore[no-untyped-call]
    recording = read(path)
    assert recording.streams()["yaw_rate"][0].size < whole
    assert any("ATTITUDE cannot be read and are left out" in note for note in recording.notes)
