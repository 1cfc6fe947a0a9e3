"""The learner that is measured or tried: `incsvr serve` as a process, a client of it, and the processes beside it."""

from __future__ import annotations

import queue
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import psutil
import zenoh

from incsvr.errors import BadInput
from service.bus.session import client_config_at, free_endpoint, open_session
from service.wire import FormType, Health, Keys, ModelSnapshot, decode
from service.wire.json_text import json_text

KEYS = Keys("leng/yaw")
PATIENCE_S = 30.0
"""How long anything may take [s] before it counts as never."""
PARTNERS = "benchmarks.bus"
"""The module whose processes speak with a learner."""
BLOCK = zenoh.CongestionControl.BLOCK
"""What is sent waits for room: a benchmark counts what the learner loses, not what the sender never sent."""


class Learner:
    """A learner that is started, killed and stopped at will; use it in a `with`.

    Args:
        state: directory of its durable state.
        router: endpoint of a router whose client it is; None where it listens itself.
        settings: of its configuration, by their keys.
    """

    def __init__(self, state: Path, router: str | None = None, **settings: Any) -> None:
        self.endpoint = router or free_endpoint()
        place = "bus.connect" if router else "bus.listen"
        chosen = {"state": str(state), place: self.endpoint, **settings}
        self._words = [word for name, value in chosen.items() for word in ("--set", f"{name}={json_text(value)}")]
        self.published: dict[int, ModelSnapshot] = {}
        self.twice = 0
        self._came = threading.Condition()
        self._alive: queue.Queue[zenoh.SampleKind] = queue.Queue()
        self._sessions: list[zenoh.Session] = []

    def __enter__(self) -> Learner:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.kill()
        self.session.close()  # type: ignore[no-untyped-call]

    @property
    def session(self) -> zenoh.Session:
        """The client's, open from the first start on."""
        return self._sessions[0]

    def start(self) -> float:
        """Starts it; gives how long it took until it was ready [s]."""
        began = time.perf_counter()
        while not self._alive.empty():
            self._alive.get()
        command = [sys.executable, "-m", "service.cli.command_line", "serve", *self._words]
        self.process = psutil.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        if not self._sessions:
            self._sessions.append(open_session(client_config_at(self.endpoint), PATIENCE_S))
            self.session.liveliness().declare_subscriber(
                KEYS.alive, lambda sample: self._alive.put(sample.kind), history=True
            )
        while self._alive.get(timeout=PATIENCE_S) != zenoh.SampleKind.PUT:
            pass
        return time.perf_counter() - began

    def note(self) -> None:
        """Notes from now on what it publishes."""
        self.session.declare_subscriber(KEYS.model, self._note)

    def kill(self) -> None:
        """Ends it as a power cut does."""
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()

    def stop(self) -> float:
        """Ends it by SIGTERM; gives how long it took [s]."""
        began = time.perf_counter()
        self.process.terminate()
        self.process.wait()  # with a time-out it would look every 0.04 s
        return time.perf_counter() - began

    def processor_s(self) -> float:
        """Its processor time so far [s]."""
        return float(sum(self.process.cpu_times()[:2]))

    def resident_mb(self) -> float:
        """Its resident memory [MB]."""
        return float(self.process.memory_info().rss / 1e6)

    def wait_for(self, more: int) -> None:
        """Waits until so many more revisions were noted."""
        with self._came:
            wanted = self.newest + more
            if not self._came.wait_for(lambda: self.newest >= wanted, PATIENCE_S):
                raise RuntimeError(f"revision {wanted} never came")

    @property
    def newest(self) -> int:
        """The newest noted revision; 0 before the first."""
        return max(self.published, default=0)

    def ask(self, selector: str, form: type[FormType]) -> FormType | None:
        """The answer to a query, asked again until there is one; None for an error reply of the learner."""
        until = time.monotonic() + PATIENCE_S
        while time.monotonic() < until:
            for reply in self.session.get(selector, timeout=5.0):
                if reply.ok is not None:
                    return decode(form, reply.ok.payload.to_bytes())
                if reply.err is not None and b"error_type" in reply.err.payload.to_bytes():
                    return None
            time.sleep(0.05)
        raise RuntimeError(f"nobody answers {selector}")

    def health(self, keys: Keys = KEYS) -> Health:
        found = self.ask(keys.health, Health)
        assert found is not None
        return found

    def wrong_answers(self, revisions: Iterable[int]) -> tuple[int, int]:
        """How many of these noted revisions are not kept, and how many are answered otherwise than published."""
        lost = wrong = 0
        for revision in revisions:
            answer = self.ask(f"{KEYS.model}?revision={revision}", ModelSnapshot)
            lost += answer is None
            wrong += answer is not None and not same(answer, self.published[revision])
        return lost, wrong

    def _note(self, sample: zenoh.Sample) -> None:
        try:
            model = decode(ModelSnapshot, sample.payload.to_bytes())
        except BadInput:
            return
        with self._came:
            before = self.published.setdefault(model.revision, model)
            self.twice += not same(before, model)
            self._came.notify_all()


def same(one: ModelSnapshot, other: ModelSnapshot) -> bool:
    """Whether two snapshots hold one model; each start publishes it again under its own boot."""
    return bool(replace(one, boot="") == replace(other, boot=""))


@contextmanager
def learner(**settings: Any) -> Iterator[Learner]:
    """A learner with durable state in a temporary directory."""
    with tempfile.TemporaryDirectory() as state, Learner(Path(state), **settings) as subject:
        yield subject


@contextmanager
def process(module: str, *words: str) -> Iterator[subprocess.Popen[bytes]]:
    """A Python module as a process that ends with the context."""
    command = [sys.executable, "-m", module, *words]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as started:
        try:
            yield started
        finally:
            started.terminate()


@contextmanager
def partner(*words: str) -> Iterator[subprocess.Popen[bytes]]:
    """One of PARTNERS as a process, from when it says that it is ready."""
    with process(PARTNERS, *words) as started:
        assert started.stdout is not None
        started.stdout.readline()
        yield started


def fed(endpoint: str, pace: float = 5.0) -> AbstractContextManager[subprocess.Popen[bytes]]:
    """Leng's run comes again and again, so many batches of samples a second, and goes on whatever happens."""
    return process(PARTNERS, "feed", endpoint, str(pace), "25")


def ask(session: zenoh.Session, selector: str) -> float:
    """How long an answer takes [s]."""
    began = time.perf_counter()
    replies = [reply.ok for reply in session.get(selector, timeout=PATIENCE_S)]
    took = time.perf_counter() - began
    if not replies or replies[0] is None:
        raise RuntimeError(f"nobody answers {selector}")
    return took
