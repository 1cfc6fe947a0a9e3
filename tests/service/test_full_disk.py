"""A disk that takes nothing: what is learned is served all the same, and is kept as soon as it can be."""

from __future__ import annotations

import queue
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import zenoh

from service import wire
from service.session import free_endpoint
from tests.service.conftest import PATIENCE, teach
from tests.service.test_processes import KEYS, answered, client_after, following, next_model, serving


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
        assert "what was learned cannot be kept" in health.reasons[0]
        assert answered(session, f"{KEYS.model}?revision=3") == unsaved
        process.send_signal(signal.SIGKILL)
        assert process.wait(PATIENCE) == -signal.SIGKILL
        assert "DELETE" in alive.get(timeout=PATIENCE)
        with serving(endpoint, disk):
            assert "PUT" in alive.get(timeout=PATIENCE)
            resumed = answered(session, KEYS.model)
            assert resumed.model_dump(exclude={"boot"}) == saved[-1].model_dump(exclude={"boot"})
            teach(session, KEYS, 9, 100.0, 140.0)
            while (model := next_model(models)).revision == resumed.revision:
                pass  # what it resumes from is said again
            assert (model.revision, model.iteration) == (4, 3)
            health_at(session, "ERROR")
            ballast.unlink()
            health_at(session, "OK")
            assert answered(session, f"{KEYS.model}?revision=4") == model
    with client_after(endpoint, disk) as (_, session, _):
        assert answered(session, KEYS.model).model_dump(exclude={"boot"}) == model.model_dump(exclude={"boot"})
