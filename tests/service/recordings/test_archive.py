"""What `serve --archive` keeps: all of it, bounded, and the same models come of it again to the byte."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
import zenoh
from mcap.reader import make_reader

from incsvr.signals import synchronise
from service import wire
from service.bus.session import free_endpoint
from service.cli.command_line import main
from service.logs.opening import archive_files
from service.recordings import archive, samples_from_recording
from service.recordings.archive import Archive
from service.recordings.archive_reader import ArchiveReader, is_archive
from service.recordings.reading import Reading
from service.recordings.recording import Recording, from_table
from simulator import leng
from tests.faults import with_faults
from tests.service.conftest import PATIENCE, StartBench, configured
from tests.service.learner.test_determinism import QUICK, without_boot
from tests.service.state.test_full_disk import disk, fill

__all__ = ["disk"]
ITERATIONS = 6
"""As many as four seconds of the quick grid hold."""
JUNK = (b"{}", b"no JSON", b'{"t": 1.0, "value": "high"}')


@pytest.fixture(scope="module")
def run() -> Recording:
    whole = leng.recording("T1", seed=12)
    part = (whole.time >= 60.0) & (whole.time < 64.0)
    return from_table(whole.name, whole.time[part] - 60.0, {n: v[part] for n, v in whole.columns.items()})


@pytest.fixture
def kept(
    start: StartBench, run: Recording, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> tuple[Path, list[bytes]]:
    """An archive of messages out of order and twice, of arrays and of junk, and the models that were served."""
    monkeypatch.setattr(archive, "CHUNK_BYTES", 5_000)  # so that four seconds fill several
    bench = start(**QUICK, archive__directory=str(tmp_path / "kept"))
    models = bench.follow(bench.keys.model, wire.ModelSnapshot)
    for payload in JUNK:
        bench.session.put(bench.keys.rate, payload, encoding=zenoh.Encoding.APPLICATION_JSON)
    bench.session.put(bench.keys.torque, wire.measurement(0.0, 1.0), encoding=zenoh.Encoding.IMAGE_PNG)
    bench.play(with_faults(run.streams(), 2, jitter=0.04, duplicates=0.1))
    array = wire.measurement((4.01, 4.02, 4.03), (0.1, 0.1, 0.1))
    bench.session.put(bench.keys.rate, array, congestion_control=zenoh.CongestionControl.BLOCK)
    bench.health_when(lambda health: health.streams["yaw_rate"].t == 4.03)
    bench.health_when(lambda health: health.iteration >= ITERATIONS)
    served = [without_boot(models.get(timeout=PATIENCE)) for _ in range(ITERATIONS)]
    bench.stop()
    return tmp_path / "kept", served


def test_the_same_models_come_of_an_archive_to_the_byte(
    start: StartBench, kept: tuple[Path, list[bytes]], run: Recording
) -> None:
    folder, served = kept
    again = start(**QUICK, prefix="other/yaw")
    models = again.follow(again.keys.model, wire.ModelSnapshot)
    what = ArchiveReader.read([folder])
    assert set(JUNK) < set(what.payloads)
    assert wire.measurement((4.01, 4.02, 4.03), (0.1, 0.1, 0.1)) in what.payloads
    again.play(what)  # type: ignore[arg-type]
    assert [without_boot(models.get(timeout=PATIENCE)) for _ in served] == served
    assert again.health().counters["rejected:wrong_encoding"] == 1
    # A file that was cut off in the middle, as by kill -9, is read up to there.
    (file,) = archive_files(folder)
    os.truncate(file, file.stat().st_size // 2)
    assert 0 < len(ArchiveReader.read([folder])) < len(what)


def test_fit_reads_an_archive_as_a_log_and_learns_the_same(kept: tuple[Path, list[bytes]]) -> None:
    folder, served = kept
    config = configured(**QUICK)
    (recording,) = Reading(rate_limit=config.vehicle.rate_limit).of_all([folder])
    samples, _ = synchronise(config.signal_settings(), recording.streams())
    for expected, iteration in zip(
        served, samples_from_recording.learn(samples, config.learner_settings()), strict=True
    ):
        snapshot = wire.decode(wire.ModelSnapshot, expected)
        assert snapshot.support.rate == tuple(iteration.model.support_rate)
        assert snapshot.support.weight == tuple(iteration.model.weight)


def test_what_went_out_is_in_it_with_the_configuration_and_other_tools_read_it(
    kept: tuple[Path, list[bytes]],
) -> None:
    folder, served = kept
    (file,) = archive_files(folder)
    with file.open("rb") as stream:
        reader = make_reader(stream)
        summary = reader.get_summary()
        assert summary is not None
        topics = {channel.topic for channel in summary.channels.values()}
        found = [message.data for _, _, message in reader.iter_messages(topics=["leng/yaw/model"])]
        (told,) = [each.metadata for each in reader.iter_metadata()]
    assert {"leng/yaw/rate", "leng/yaw/torque", "leng/yaw/iteration", "leng/yaw/health", "leng/yaw/effects"} < topics
    assert [without_boot(wire.decode(wire.ModelSnapshot, payload)) for payload in found] == served
    assert '"smoothing": 0.03' in told["config"]
    assert told["prefix"] == "leng/yaw"


def test_files_are_rotated_and_bounded_and_go_on_after_a_restart(tmp_path: Path) -> None:
    most = 4_000_000
    for _ in range(2):
        kept = Archive(tmp_path, "a/b", {}, file_bytes=500_000, most_bytes=most)
        for number in range(60):
            kept.came("a/b/rate", "application/json", os.urandom(100_000))
            assert number or not kept.notices()
        kept.close()
        assert not kept.notices()
    files = archive_files(tmp_path, "a-b")
    numbers = [int(path.stem[-6:]) for path in files]
    assert numbers == list(range(numbers[0], numbers[0] + len(files)))
    assert numbers[0] > 1
    assert len(files) >= 3
    assert most / 2 < sum(path.stat().st_size for path in files) <= most


TAKEN: dict[str, Callable[[Path], object]] = {
    "the file": lambda file: file.unlink(),
    "the folder": lambda file: shutil.rmtree(file.parent),
    "its name": lambda file: file.rename(file.with_suffix(".moved")),
    "its content": lambda file: os.truncate(file, 0),
    "its place": lambda file: Path(shutil.copy(file, file.with_suffix(".copy"))).replace(file),
}


@pytest.mark.parametrize("taken", TAKEN)
def test_what_is_taken_from_under_it_is_said_and_another_file_begun(
    start: StartBench, run: Recording, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, taken: str
) -> None:
    monkeypatch.setattr(archive, "CHUNK_BYTES", 1_000)
    folder = tmp_path / "kept"
    bench = start(**QUICK, archive__directory=str(folder))
    bench.play(run)
    (file,) = archive_files(folder)
    bench.health_when(lambda _: file.stat().st_size > 10_000)
    TAKEN[taken](file)
    told = bench.health_when(lambda health: any("another one was begun" in reason for reason in health.reasons))
    assert any(f"the archive's file {file} was removed, renamed or cut" in reason for reason in told.reasons)
    bench.health_when(lambda health: any(reason.endswith("are missing in the archive") for reason in health.reasons))
    bench.play(run)
    bench.stop()
    newest = archive_files(folder)[-1]
    assert newest.name == "leng-yaw_000002.mcap"
    assert len(ArchiveReader.read([newest])) >= run.time.size


def test_on_a_full_disk_health_says_so_and_nothing_else_stops(
    start: StartBench, disk: Path, run: Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(archive, "RETRY_S", 0.1)
    fill(disk)
    bench = start(**QUICK, archive__directory=str(disk / "kept"))
    told = bench.health_when(lambda health: any("not archived" in reason for reason in health.reasons))
    assert any("no space is left on the disk" in reason for reason in told.reasons)
    bench.play(run)
    bench.health_when(lambda health: health.iteration >= 5)
    (disk / "ballast").unlink()
    bench.health_when(lambda health: any("are missing in the archive" in reason for reason in health.reasons))
    bench.play(run)
    bench.stop()
    assert len(ArchiveReader.read([disk / "kept"])) >= run.time.size


def test_where_nothing_can_be_kept_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("")
    assert main(["serve", "--archive", str(tmp_path / "file"), "--set", "state=null", "--listen", free_endpoint()]) == 2
    assert "name another one with --archive" in capsys.readouterr().err
    assert not is_archive(tmp_path)
