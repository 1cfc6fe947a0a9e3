"""What a first question needs is loaded beside the thread that answers."""

from __future__ import annotations

import json
import subprocess
import threading
import time
from pathlib import Path

import pytest
import zenoh

from service import wire
from service.bus.session import client_config_at, free_endpoint, open_session
from tests.service.commands.test_processes import command
from tests.service.conftest import PATIENCE

MAX_HEALTH_S = 1.0
"""Longest wait for health [s] while others are answered: what is loaded takes 2 s, and 4 s on a loaded machine."""


def ask(session: zenoh.Session, key: str, payload: bytes | None = None) -> bytes:
    (reply,) = session.get(key, payload=payload, timeout=PATIENCE)
    said = reply.ok or reply.err
    assert said is not None
    return said.payload.to_bytes()


@pytest.mark.slow
def test_the_first_question_for_feedforward_keeps_nobody_waiting(tmp_path: Path) -> None:
    endpoint, keys = free_endpoint(), wire.Keys("leng/yaw")
    words = command("serve", "--listen", endpoint, "--set", f"state={tmp_path / 'state'}")
    with subprocess.Popen(words, stderr=subprocess.DEVNULL) as learner:
        try:
            with open_session(client_config_at(endpoint), PATIENCE) as session:
                while not list(session.liveliness().get(keys.alive, timeout=PATIENCE)):
                    pass
                ask(session, keys.health)
                refused: list[str] = []
                plan = json.dumps({"t": [0, 1], "rate": [0, 0.1]}).encode()
                asker = threading.Thread(target=lambda: refused.append(ask(session, keys.feedforward, plan).decode()))
                asker.start()
                waits = []
                while asker.is_alive():
                    began = time.monotonic()
                    ask(session, keys.health)
                    waits.append(time.monotonic() - began)
        finally:
            learner.terminate()
    assert "nothing has been learned yet" in refused[0]
    assert len(waits) > 3
    assert max(waits) < MAX_HEALTH_S
