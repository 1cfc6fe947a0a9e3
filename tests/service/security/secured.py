"""A bus secured by `incsvr keys`, on loopback, with a learner on it and a client in every role."""

from __future__ import annotations

import queue
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import zenoh
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization

from service import wire
from service.bus.session import free_endpoint, from_file, open_session
from service.cli.command_line import main
from service.host.host import Host
from service.host.worker_threads import WorkerThreads
from service.security.authority import load
from tests.service.conftest import PATIENCE, configured, teach

KEYS = wire.Keys("rov7/yaw")
UNSERVED = wire.Keys("rov7/pitch")
"""A prefix of the same access control below which no learner answers, so that every answer there is a forgery."""
FORGED = b"forged"


@dataclass(frozen=True)
class Secured:
    """A learner that has learned, in a session of the learner's role, and a client in every other role."""

    folder: Path
    endpoint: str
    learner: zenoh.Session
    clients: dict[str, zenoh.Session]


@contextmanager
def secured(folder: Path, state: Path) -> Iterator[Secured]:
    """The bus of one module of tests; certificates go to a folder, the learner's state to another."""
    endpoint = free_endpoint().replace("tcp/", "tls/")
    prefixes = ["--prefix", KEYS.prefix, "--prefix", UNSERVED.prefix]
    assert main(["keys", str(folder), *prefixes, "--listen", endpoint]) == 0
    with ExitStack() as stack:
        learner = stack.enter_context(open_session(from_file(folder / "learner.json5")))
        config = configured(prefix=KEYS.prefix, state=state)
        stack.enter_context(WorkerThreads([Host(learner, config)]))
        clients = {
            role: stack.enter_context(open_session(from_file(folder / f"{role}.json5"), PATIENCE))
            for role in ("vehicle", "viewer", "operator")
        }
        models: queue.Queue[Any] = queue.Queue()
        clients["viewer"].declare_subscriber(KEYS.model, models.put)
        until_settled(clients["viewer"])
        teach(clients["vehicle"], KEYS, 6, 0.0, 40.0)
        models.get(timeout=PATIENCE)
        yield Secured(folder, endpoint, learner, clients)


def redated(folder: Path, name: str, begins: timedelta, ends: timedelta) -> None:
    """The certificate of this name again, valid between other times, counted from now."""
    by = load((folder / "ca.pem").read_bytes(), (folder / "ca.key").read_bytes())
    found = x509.load_pem_x509_certificate((folder / f"{name}.pem").read_bytes())
    again = x509.CertificateBuilder(
        issuer_name=found.issuer,
        subject_name=found.subject,
        public_key=found.public_key(),
        serial_number=found.serial_number,
        extensions=list(found.extensions),
    )
    now = datetime.now(UTC)
    dated = again.not_valid_before(now + begins).not_valid_after(now + ends).sign(by.key, hashes.SHA256())
    (folder / f"{name}.pem").write_bytes(dated.public_bytes(serialization.Encoding.PEM))


def until_settled(client: zenoh.Session, keys: wire.Keys = KEYS) -> None:
    """Returns once all that the client has sent and declared has been let through or denied."""
    until = time.monotonic() + PATIENCE
    # A session that has just been opened may not know yet who answers; its question ends at once then.
    while not list(client.get(keys.health, timeout=PATIENCE)):
        assert time.monotonic() < until, "the learner does not answer for its health"
