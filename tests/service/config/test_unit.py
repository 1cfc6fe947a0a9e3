"""The unit of deploy/, and what the learner tells systemd over a real socket of ours."""

from __future__ import annotations

import os
import queue
import re
import shutil
import signal
import socket
import subprocess
import sys
import threading
import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from service.bus.session import free_endpoint, listener_config_at, open_session
from service.host.host import Host
from service.host.worker_threads import WorkerThreads
from tests.conftest import ROOT
from tests.service.conftest import PATIENCE, configured

UNIT = ROOT / "deploy" / "incsvr.service"
WATCHDOG = 0.6
"""The watchdog's time in these tests [s]; the unit's is 30 s."""

needs_systemd_analyze = pytest.mark.skipif(
    shutil.which("systemd-analyze") is None, reason="systemd-analyze, which comes with systemd, is not installed"
)


@needs_systemd_analyze
def test_the_unit_is_hardened() -> None:
    words = ["systemd-analyze", "security", "--offline=yes", "--no-pager", "--threshold=29", str(UNIT)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    exposure = re.search(r"Overall exposure level for incsvr.service: (\d+\.\d)", done.stdout)
    assert exposure, done.stdout + done.stderr
    assert float(exposure[1]) < 3.0
    assert done.returncode == 0


@needs_systemd_analyze
def test_systemd_understands_every_line_of_the_unit(tmp_path: Path) -> None:
    # The program that it starts must exist: ours stands where the test runs.
    text = UNIT.read_text(encoding="utf-8").replace("/opt/incsvr/bin/incsvr", sys.executable)
    (tmp_path / UNIT.name).write_text(text, encoding="utf-8")
    words = ["systemd-analyze", "verify", "--man=no", str(tmp_path / UNIT.name)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert "incsvr.service" not in done.stderr
    assert done.returncode == 0


linux = pytest.mark.skipif(sys.platform != "linux", reason="the abstract namespace of sockets is Linux's")


@pytest.fixture(params=["path", pytest.param("abstract", marks=linux)])
def systemd(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[tuple[str, socket.socket]]:
    """A socket as systemd listens at, and its name in $NOTIFY_SOCKET."""
    name = str(tmp_path / "notify") if request.param == "path" else f"@incsvr-{uuid.uuid4().hex}"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listener:
        listener.bind(name.replace("@", "\0"))
        listener.settimeout(PATIENCE)
        yield name, listener


def told(listener: socket.socket) -> str:
    return listener.recv(4096).decode()


def until(listener: socket.socket, word: str) -> None:
    """Returns once this is told; only the watchdog is stroked before."""
    while (next_word := told(listener)) != word:
        assert next_word == "WATCHDOG=1"


def drain(listener: socket.socket) -> None:
    """Takes what was told already."""
    listener.settimeout(0.0)
    try:
        while True:
            listener.recv(4096)
    except BlockingIOError:
        listener.settimeout(PATIENCE)


def test_systemd_hears_that_it_is_ready_learns_hangs_and_stops(
    systemd: tuple[str, socket.socket], tmp_path: Path
) -> None:
    name, listener = systemd
    environment = os.environ | {"NOTIFY_SOCKET": name, "WATCHDOG_USEC": str(round(WATCHDOG * 1e6))}
    words = ["serve", "--listen", free_endpoint(), "--set", f"state={tmp_path / 'state'}"]
    with subprocess.Popen(
        [sys.executable, "-m", "service.cli.command_line", *words], env=environment, stderr=subprocess.DEVNULL
    ) as learner:
        try:
            until(listener, "READY=1")
            assert told(listener) == "WATCHDOG=1"
            learner.send_signal(signal.SIGSTOP)
            os.waitid(os.P_PID, learner.pid, os.WSTOPPED | os.WNOWAIT)
            drain(listener)
            listener.settimeout(WATCHDOG)
            with pytest.raises(TimeoutError):
                told(listener)
            listener.settimeout(PATIENCE)
            learner.send_signal(signal.SIGCONT)
            assert told(listener) == "WATCHDOG=1"
            learner.send_signal(signal.SIGTERM)
            until(listener, "STOPPING=1")
            assert learner.wait(PATIENCE) == 0
        finally:
            learner.kill()


class Hanging(Host):
    """A learner whose iteration does not end while it is held."""

    def __init__(self, *words: Any) -> None:
        super().__init__(*words)
        self.entered, self.go_on = threading.Event(), threading.Event()
        self.go_on.set()

    def learn(self) -> bool:
        if not self.go_on.is_set():
            self.entered.set()
            self.go_on.wait()
        return super().learn()


def test_a_thread_that_learns_no_more_strokes_no_more() -> None:
    """While it hangs all other threads go on and answer, which a watchdog must not take for learning."""
    strokes: queue.Queue[None] = queue.Queue()
    with open_session(listener_config_at(free_endpoint())) as session:
        host = Hanging(session, configured())
        with WorkerThreads([host], lambda: strokes.put(None), 0.02):
            strokes.get(timeout=PATIENCE)
            host.go_on.clear()
            assert host.entered.wait(PATIENCE)
            while not strokes.empty():
                strokes.get()
            (reply,) = list(session.get(host.keys.health, timeout=PATIENCE))
            assert reply.ok is not None
            assert strokes.empty()
            host.go_on.set()
            strokes.get(timeout=PATIENCE)
