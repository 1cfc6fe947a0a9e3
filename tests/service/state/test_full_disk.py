"""A disk that takes nothing: what is learned is served all the same, and is kept as soon as it can be."""

from __future__ import annotations

import queue
import signal
import subprocess
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
import zenoh

from incsvr.errors import BadInput
from service import wire
from service.bus.bus_check import check_files
from service.bus.session import free_endpoint
from service.state.disk_refusals import OTHER_STATE
from service.state.history import History, NotKept
from service.state.store import Store
from service.wire import encode
from tests.service.commands.test_processes import KEYS, answered, client_after, following, next_model, serving
from tests.service.conftest import PATIENCE, configured, teach
from tests.service.state.conftest import Saved, save


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Path]:
    """A file system of its own, of two megabytes."""
    place = tmp_path / "disk"
    place.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=2m", "tmpfs", place], capture_output=True, text=True, check=False
    )
    if mounted.returncode:
        pytest.skip(f"a small file system cannot be mounted here: {mounted.stderr.strip()}")
    yield place
    subprocess.run(["umount", "--lazy", place], check=True)


def fill(disk: Path) -> Path:
    """Leaves no byte free on it."""
    ballast = disk / "ballast"
    with ballast.open("wb", buffering=0) as file:
        try:
            while True:
                file.write(b"x" * 4096)
        except OSError:
            return ballast


def health_at(session: zenoh.Session, level: str) -> wire.Health:
    """Asks until health has this level or better."""
    until = time.monotonic() + PATIENCE
    while True:
        (reply,) = list(session.get(KEYS.health, timeout=PATIENCE))
        assert reply.ok is not None
        health = wire.decode(wire.Health, reply.ok.payload.to_bytes())
        if (health.level == "ERROR") == (level == "ERROR"):
            return health
        assert time.monotonic() < until, health


@pytest.mark.slow
def test_on_a_full_disk_it_learns_starts_and_recovers_and_no_revision_is_two_models(disk: Path) -> None:
    endpoint = free_endpoint()
    models: queue.Queue[wire.ModelSnapshot]
    with client_after(endpoint, disk) as (process, session, alive):
        models = following(session)
        teach(session, KEYS, 9, 0.0, 70.0)
        saved = [next_model(models), next_model(models)]
        ballast = fill(disk)
        teach(session, KEYS, 9, 70.0, 100.0)
        unsaved = next_model(models)
        assert unsaved.revision == 3
        health = health_at(session, "ERROR")
        assert "the state cannot be saved" in health.reasons[0]
        assert answered(session, f"{KEYS.model}?revision=3") == unsaved
        process.send_signal(signal.SIGKILL)
        assert process.wait(PATIENCE) == -signal.SIGKILL
        assert "DELETE" in alive.get(timeout=PATIENCE)
        with serving(endpoint, disk):
            assert "PUT" in alive.get(timeout=PATIENCE)
            lost = "revision 3 was published and is lost: the disk does not have it"
            assert lost in health_at(session, "WARN").reasons
            assert refused(session, f"{KEYS.model}?revision=3") == f"revision 3 is not kept; {lost}"
            resumed = answered(session, KEYS.model)
            assert replace(resumed, boot="") == replace(saved[-1], boot="")
            teach(session, KEYS, 9, 100.0, 140.0)
            while (model := next_model(models)).revision == resumed.revision:
                pass  # what it resumes from is said again
            assert (model.revision, model.iteration) == (4, 3)
            health_at(session, "ERROR")
            ballast.unlink()
            health_at(session, "OK")
            assert answered(session, f"{KEYS.model}?revision=4") == model
    with client_after(endpoint, disk) as (_, session, _):
        assert replace(answered(session, KEYS.model), boot="") == replace(model, boot="")
        assert lost not in health_at(session, "OK").reasons
        assert refused(session, f"{KEYS.damping}?rate=0.1;revision=3") == f"revision 3 is not kept; {lost}"


def refused(session: zenoh.Session, selector: str) -> str:
    """The error that a question gets."""
    (reply,) = list(session.get(selector, timeout=PATIENCE))
    assert reply.err is not None
    return wire.decode(wire.ErrorReply, reply.err.payload.to_bytes()).error


def test_what_waited_in_vain_for_the_disk_is_one_gap_that_is_remembered(
    disk: Path, outcomes: list[Saved], caplog: pytest.LogCaptureFixture
) -> None:
    store = Store(disk, configured())
    save(store, outcomes[0])
    ballast = fill(disk)
    for outcome in outcomes[1:3]:
        save(store, outcome)
    assert store.problem == f"no space is left on the disk of {disk}/leng/yaw.sqlite; free some, or {OTHER_STATE}"
    store.close()
    ballast.unlink()
    gap = "revisions 2 to 3 were published and are lost: the disk does not have them"
    for told in ((gap,), ()):  # by the start that finds it, and not for ever
        store = Store(disk, configured())
        assert (store.published, store.notices) == (3 if told else 4, told)
        with pytest.raises(NotKept, match=f"revision 3 is not kept; {gap}"):
            store.history.revision(3)
        if told:
            assert gap in caplog.text
            outcome = outcomes[1]
            store.save(outcome.memory, 4, 90.0, encode(outcome.snapshot), encode(outcome.report))
        store.close()


def test_what_waits_too_long_for_the_disk_is_a_gap() -> None:
    history = History(100, waiting_bytes=40)
    for revision in range(1, 8):
        history.add(revision, float(revision), b"x" * 5, b"y" * 5)
    assert history.gaps == ("revisions 1 to 3 were published and are lost: the disk does not have them",)
    history.lose(9, 9)
    assert history.lost == ((1, 3), (9, 9))


@pytest.mark.parametrize("there", ["nothing", "an empty lock", "a state"])
def test_a_start_on_a_read_only_disk_names_the_cure_and_goes_on_once_it_can_be_written(
    disk: Path, outcomes: list[Saved], there: str
) -> None:
    if there == "a state":
        store = Store(disk, configured())
        save(store, outcomes[0])
        store.close()
    elif there == "an empty lock":
        (disk / "leng").mkdir()
        (disk / "leng" / "yaw.lock").touch()
    subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
    store = Store(disk, configured())
    why_not = f"the file system at {disk} is read-only; make it writable (`mount -o remount,rw {disk}`"
    assert (store.problem or "").startswith(why_not)
    save(store, outcomes[1])
    assert (store.problem or "").startswith(why_not)
    with pytest.raises(BadInput, match="is read-only"):
        check_files(configured(state=disk / "other"), Path(__file__), None)
    subprocess.run(["mount", "-o", "remount,rw", disk], check=True)
    assert store.due
    store.save_again()
    assert store.problem is None
    store.close()
    store = Store(disk, configured())
    assert store.history.revision(2).snapshot == encode(outcomes[1].snapshot)
    store.close()
