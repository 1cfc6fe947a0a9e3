"""What the tests of the viewer share: iterations of the real learner, and learner and viewer as real processes."""

from __future__ import annotations

import queue
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import zenoh

from incsvr.numerics import Array
from service.bus.session import client_config_at, free_endpoint, open_session
from service.config.sources import read
from service.learner.node import LearnerNode
from service.wire import Health, IterationReport, Keys, Measurement, ModelSnapshot, decode, encode
from simulator.leng import recording

PATIENCE = 60.0
"""How long a test waits for what must come [s]."""
KEYS = Keys("leng/yaw")
Streams = dict[str, tuple[Array, Array]]


@dataclass(frozen=True)
class Run:
    """A part of the Leng experiment and what the learner makes of it."""

    streams: Streams
    iterations: list[tuple[IterationReport, ModelSnapshot]]

    def part(self, start: float, end: float) -> Streams:
        """The messages with stamps in (start, end] [s]."""
        chosen = {}
        for name, (t, value) in self.streams.items():
            inside = (t > start) & (t <= end)
            chosen[name] = t[inside], value[inside]
        return chosen


@pytest.fixture(scope="session")
def run() -> Run:
    """Leng's T1, seed 1, through the learner's own node: seven iterations and more."""
    streams = {name: values for name, values in recording("T1", 1).streams().items() if name in ("yaw_rate", "torque")}
    node = LearnerNode(read(None, {"state": None}), "a test")
    iterations = []
    for name in streams:
        node.push(name, *streams[name])
    while (outcome := node.learn()) is not None:
        iterations.append((outcome.report, outcome.served))
    assert len(iterations) >= 7
    return Run(streams, iterations)


class Process:
    """A command of ours, with what it says on standard error line by line."""

    def __init__(self, words: list[str], limit_file: int | None = None) -> None:
        program = "import sys; from service.cli.command_line import main; sys.exit(main())"
        if limit_file is not None:
            # What a full disk looks like to a writer, without filling one.
            program = (
                f"import resource; resource.setrlimit(resource.RLIMIT_FSIZE, ({limit_file}, {limit_file})); {program}"
            )
        self._process = subprocess.Popen(
            [sys.executable, "-c", program, *words], stderr=subprocess.PIPE, text=True, errors="replace"
        )
        self._lines: queue.Queue[str | None] = queue.Queue()
        self.said: list[str] = []
        threading.Thread(target=self._read, daemon=True).start()

    def wait_for(self, text: str) -> str:
        """The next line that holds `text`, said from where the last wait ended."""
        until = time.monotonic() + PATIENCE
        while True:
            try:
                line = self._lines.get(timeout=max(0.0, until - time.monotonic()))
            except queue.Empty:
                line = None
            if line is None:
                pytest.fail(f"nobody said {text!r}, only:\n{''.join(self.said)}")
            self.said.append(line)
            if text in line:
                return line

    def end(self, number: signal.Signals = signal.SIGTERM) -> int:
        """Signals the process and waits for its end."""
        self._process.send_signal(number)
        return self._process.wait(PATIENCE)

    def wait(self) -> int:
        """Waits for its end."""
        return self._process.wait(PATIENCE)

    def signal(self, number: signal.Signals) -> None:
        self._process.send_signal(number)

    def close(self) -> None:
        if self._process.poll() is None:
            self._process.kill()
        self._process.wait()

    def _read(self) -> None:
        assert self._process.stderr is not None
        with self._process.stderr as lines:
            for line in lines:
                self._lines.put(line)
        self._lines.put(None)


@dataclass
class House:
    """A learner and viewers as processes, and a client of the bus beside them."""

    stack: ExitStack
    folder: Path
    endpoint: str

    def serve(self, *words: str, durable: bool = True) -> Process:
        """Starts the learner, on the state it left, or with none."""
        state = self.folder / "state" if durable else "null"
        where = ("--set", f"bus.listen={self.endpoint}", "--set", f"state={state}")
        learner = self.start(["serve", *where, *words])
        learner.wait_for("ready")
        return learner

    def view(self, *words: str, limit_file: int | None = None) -> Process:
        """Starts a viewer."""
        return self.start(["view", "--connect", self.endpoint, *words], limit_file)

    def client(self) -> zenoh.Session:
        return self.stack.enter_context(open_session(client_config_at(self.endpoint), PATIENCE))

    def start(self, words: list[str], limit_file: int | None = None) -> Process:
        """Starts any command."""
        process = Process(words, limit_file)
        self.stack.callback(process.close)
        return process


@pytest.fixture
def house(tmp_path: Path) -> Iterator[House]:
    with ExitStack() as stack:
        yield House(stack, tmp_path, free_endpoint())


def publish(session: zenoh.Session, streams: Streams) -> None:
    """Puts the messages on the bus, a second of them at a time, and returns when the learner has them."""
    for name, (t, value) in streams.items():
        for part in np.array_split(np.arange(t.size), max(1, t.size // 50)):
            form = Measurement(t=tuple(t[part].tolist()), value=tuple(value[part].tolist()))
            session.put(KEYS.stream(name), encode(form), congestion_control=zenoh.CongestionControl.BLOCK)
    health(session)


def health(session: zenoh.Session) -> Health:
    """The learner's answer; it comes after everything that was put before."""
    for reply in session.get(KEYS.health, timeout=PATIENCE):
        if reply.ok is not None:
            return decode(Health, reply.ok.payload.to_bytes())
    pytest.fail("the learner does not answer for its health")


def learn_until(session: zenoh.Session, iteration: int, act: Callable[[], None]) -> None:
    """Does `act`, and returns when the learner has done this iteration."""
    done = threading.Event()

    def seen(sample: zenoh.Sample) -> None:
        if decode(IterationReport, sample.payload.to_bytes()).iteration >= iteration:
            done.set()

    watcher = session.declare_subscriber(KEYS.iteration, seen)
    act()
    assert done.wait(PATIENCE) or health(session).iteration >= iteration
    watcher.undeclare()  # type: ignore[no-untyped-call]
