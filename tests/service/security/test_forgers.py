"""Who is not what he says on a secured bus: a forger, a client in the learner's place, a stranger, a mute player."""

from __future__ import annotations

import json
import queue
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import zenoh
from zenoh.ext import (
    CacheConfig,
    HistoryConfig,
    RecoveryConfig,
    declare_advanced_publisher,
    declare_advanced_subscriber,
)

from incsvr.errors import BadInput
from service import wire
from service.bus.session import client_config_at, free_endpoint, from_file, open_session
from service.cli.command_line import main
from service.recordings.recording_csv import write
from simulator import leng
from tests.service.conftest import PATIENCE
from tests.service.security.secured import FORGED, KEYS, Secured, secured, until_settled


@pytest.fixture(scope="module")
def bus(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Secured]:
    with secured(tmp_path_factory.mktemp("keys"), tmp_path_factory.mktemp("state")) as found:
        yield found


@pytest.mark.parametrize("mode", ["client", "peer", "router"])
def test_beside_the_learner_a_forger_is_not_heard(bus: Secured, mode: str) -> None:
    """It answers, publishes and keeps models where the learner does, also where it says that it is a router itself."""
    config = from_file(bus.folder / "viewer.json5")
    config.insert_json5("mode", json.dumps(mode))
    config.insert_json5("listen/endpoints", "[]")
    asker = bus.clients["operator"]
    heard: queue.Queue[bytes] = queue.Queue()
    with open_session(config, PATIENCE) as forger:
        forger.declare_queryable(KEYS.damping, lambda query: query.reply(KEYS.damping, FORGED), complete=True)
        publisher: Any = declare_advanced_publisher(
            forger, KEYS.model, cache=CacheConfig(max_samples=1), publisher_detection=True
        )
        publisher.put(FORGED)
        until_settled(forger)
        late: Any = declare_advanced_subscriber(
            asker,
            KEYS.model,
            lambda sample: heard.put(sample.payload.to_bytes()),
            history=HistoryConfig(detect_late_publishers=True, max_samples=1),
            recovery=RecoveryConfig(periodic_queries=None, heartbeat=True),
        )
        assert wire.decode(wire.ModelSnapshot, heard.get(timeout=PATIENCE)).revision == 1
        for key in (f"{KEYS.damping}?rate=0.1", f"{KEYS.model}/@adv/**?_anyke;_max=1"):
            replies = list(asker.get(key, target=zenoh.QueryTarget.ALL, timeout=PATIENCE))
            assert [reply.ok is not None and reply.ok.payload.to_bytes() != FORGED for reply in replies] == [True]
        publisher.put(FORGED)
        until_settled(forger)
        until_settled(asker)
        late.undeclare()
    assert heard.empty()


def test_a_clients_certificate_cannot_play_the_learner(bus: Secured, tmp_path: Path) -> None:
    """Where the learner is away and its port is free, its clients refuse who listens there."""
    endpoint = free_endpoint().replace("tcp/", "tls/")
    for role in ("learner", "vehicle"):
        text = (bus.folder / f"{role}.json5").read_text(encoding="utf-8").replace(bus.endpoint, endpoint)
        text = text.replace("learner.pem", "viewer.pem").replace("learner.key", "viewer.key")
        (tmp_path / f"{role}.json5").write_text(text, encoding="utf-8")
    with open_session(from_file(tmp_path / "learner.json5")), pytest.raises(BadInput, match="cannot be opened"):
        open_session(from_file(tmp_path / "vehicle.json5"))


def test_without_a_certificate_of_the_authority_nobody_comes_in(bus: Secured, tmp_path: Path) -> None:
    assert main(["keys", str(tmp_path), "--role", "vehicle", "--listen", bus.endpoint]) == 0
    (tmp_path / "ca.pem").write_bytes((bus.folder / "ca.pem").read_bytes())
    stranger = from_file(tmp_path / "vehicle.json5")
    for config in (client_config_at(bus.endpoint.replace("tls/", "tcp/")), client_config_at(bus.endpoint), stranger):
        with pytest.raises(BadInput, match="the bus cannot be opened"):
            open_session(config)


@pytest.mark.slow
@pytest.mark.parametrize(("role", "status"), [("viewer", 1), ("vehicle", 0)])
def test_a_player_that_is_not_heard_says_so_at_once(bus: Secured, tmp_path: Path, role: str, status: int) -> None:
    run = leng.recording("V1", seed=1)
    write(tmp_path / "run.csv", run)
    words = ["--prefix", KEYS.prefix, "--set", f"bus.zenoh_file={bus.folder / f'{role}.json5'}", "--speed", "200"]
    done = subprocess.run(
        [sys.executable, "-m", "service.cli.command_line", "replay", str(tmp_path / "run.csv"), *words],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == status, done.stderr
    refusal = f"receives nothing on {KEYS.rate} and {KEYS.torque}: this client may not publish there"
    assert (refusal in done.stderr) is (role == "viewer")
    assert "Traceback" not in done.stderr
