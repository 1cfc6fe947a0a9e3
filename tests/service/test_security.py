"""The secured bus of deploy/, on loopback: who has the right certificate may do what its role may, and nobody else."""

from __future__ import annotations

import queue
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
import zenoh

from incsvr.errors import BadInput
from service import wire
from service.crew import Crew
from service.host import Host
from service.session import connecting, free_endpoint, from_file, open_session
from simulator import leng
from tests.conftest import ROOT
from tests.service.conftest import PATIENCE, configured, teach

KEYS = wire.Keys("leng/yaw")


@pytest.fixture(scope="module")
def certificates(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if shutil.which("openssl") is None:
        pytest.skip("openssl, which makes the certificates, is not installed")
    folder = tmp_path_factory.mktemp("tls")
    subprocess.run([ROOT / "deploy" / "certificates.sh", folder], check=True, capture_output=True)
    return folder


@pytest.fixture
def endpoint(certificates: Path) -> Iterator[str]:
    """A learner on the secured bus."""
    endpoint = free_endpoint().replace("tcp/", "tls/")
    config = adapted("zenoh-learner.json5", certificates, endpoint, "learner")
    with open_session(from_file(config)) as session, Crew([Host(session, configured())]):
        yield endpoint


def adapted(name: str, certificates: Path, endpoint: str, role: str) -> Path:
    """A file of deploy/ with this test's port, certificates and role."""
    text = (ROOT / "deploy" / name).read_text(encoding="utf-8")
    text = text.replace("tls/127.0.0.1:7447", endpoint).replace("/etc/incsvr/tls", str(certificates))
    path = certificates / f"{role}-{name}"
    path.write_text(text.replace("viewer.", f"{role}."), encoding="utf-8")
    return path


@contextmanager
def client(certificates: Path, endpoint: str, role: str) -> Iterator[zenoh.Session]:
    with open_session(from_file(adapted("zenoh-client.json5", certificates, endpoint, role)), PATIENCE) as session:
        yield session


def test_a_sensor_measures_and_a_viewer_looks(certificates: Path, endpoint: str) -> None:
    models: queue.Queue[wire.ModelSnapshot] = queue.Queue()
    with ExitStack() as stack:
        viewer = stack.enter_context(client(certificates, endpoint, "viewer"))
        sensor = stack.enter_context(client(certificates, endpoint, "sensor"))
        viewer.declare_subscriber(
            KEYS.model, lambda sample: models.put(wire.decode(wire.ModelSnapshot, sample.payload.to_bytes()))
        )
        teach(sensor, KEYS, 6, 0.0, 40.0)
        assert models.get(timeout=PATIENCE).iteration == 1
        (reply,) = list(viewer.get(f"{KEYS.damping}?rate=0.1", timeout=PATIENCE))
        assert reply.ok is not None
        # Each is refused what the other may: nothing comes of it, and the bus goes on.
        teach(viewer, KEYS, 6, 0.0, 40.0)
        assert list(sensor.get(f"{KEYS.damping}?rate=0.1", timeout=1.0)) == []
        (reply,) = list(sensor.get(KEYS.health, timeout=PATIENCE))
        assert reply.ok is not None
        health = wire.decode(wire.Health, reply.ok.payload.to_bytes())
        assert health.iteration == 1
        assert health.streams["torque"].received == sum(leng.recording("T1", seed=6).streams()["torque"][0] < 40.0)


def test_without_its_certificate_nobody_comes_in(certificates: Path, endpoint: str) -> None:
    with pytest.raises(BadInput, match="the bus cannot be opened"):
        open_session(connecting(endpoint.replace("tls/", "tcp/")), 0.5)
    with pytest.raises(BadInput, match="the bus cannot be opened"):
        open_session(connecting(endpoint), 0.5)
