"""The learner that is tried: `incsvr serve` as a process on a state of its own, and a client that notes its models."""

from __future__ import annotations

import queue
import subprocess
import sys
import threading
import time
from collections.abc import Iterable
from contextlib import AbstractContextManager
from pathlib import Path

import zenoh

from benchmarks.bus import KEYS, PARTNERS, PATIENCE_S, process
from incsvr.errors import BadInput
from service.bus.session import client_config_at, free_endpoint, open_session
from service.wire import Form, FormType, Health, ModelSnapshot, decode
from service.wire.json_text import json_text


class Subject:
    """A learner that is started, killed and stopped at will; use it in a `with`.

    Args:
        state: directory of its durable state.
        router: endpoint of a router whose client it is; None where it listens itself.
    """

    def __init__(self, state: Path, router: str | None = None) -> None:
        self.endpoint = router or free_endpoint()
        place = f"bus.connect={router}" if router else f"bus.listen={self.endpoint}"
        self._words = ["--set", place, "--set", f"state={json_text(str(state))}"]
        self.published: dict[int, ModelSnapshot] = {}
        self.twice = 0
        self._came = threading.Condition()
        self._alive: queue.Queue[zenoh.SampleKind] = queue.Queue()
        self._sessions: list[zenoh.Session] = []

    def __enter__(self) -> Subject:
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
        began = time.monotonic()
        while not self._alive.empty():
            self._alive.get()
        command = [sys.executable, "-m", "service.cli.command_line", "serve", *self._words]
        self.process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        if not self._sessions:
            self._sessions.append(open_session(client_config_at(self.endpoint), PATIENCE_S))
            self.session.liveliness().declare_subscriber(
                KEYS.alive, lambda sample: self._alive.put(sample.kind), history=True
            )
            self.session.declare_subscriber(KEYS.model, self._note)
        while self._alive.get(timeout=PATIENCE_S) != zenoh.SampleKind.PUT:
            pass
        return time.monotonic() - began

    def kill(self) -> None:
        """Ends it as a power cut does."""
        self.process.kill()
        self.process.wait()

    def stop(self) -> float:
        """Ends it by SIGTERM; gives how long it took [s]."""
        began = time.monotonic()
        self.process.terminate()
        self.process.wait(PATIENCE_S)
        return time.monotonic() - began

    def wait_for(self, more: int) -> None:
        """Waits until so many more revisions were published."""
        with self._came:
            wanted = self.newest + more
            if not self._came.wait_for(lambda: self.newest >= wanted, PATIENCE_S):
                raise RuntimeError(f"revision {wanted} never came")

    @property
    def newest(self) -> int:
        """The newest published revision; 0 before the first."""
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

    def health(self) -> Health:
        found = self.ask(KEYS.health, Health)
        assert found is not None
        return found

    def wrong_answers(self, revisions: Iterable[int]) -> tuple[int, int]:
        """How many of these published revisions are not kept, and how many are answered otherwise than published."""
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


def same(one: Form, other: Form) -> bool:
    """Whether two snapshots hold one model; each start publishes it again under its own boot."""
    return one.model_dump(exclude={"boot"}) == other.model_dump(exclude={"boot"})


def fed(endpoint: str, pace: float = 5.0) -> AbstractContextManager[subprocess.Popen[bytes]]:
    """Leng's run comes again and again, so many batches of samples a second, and goes on whatever happens."""
    return process(PARTNERS, "feed", endpoint, str(pace), "25")
