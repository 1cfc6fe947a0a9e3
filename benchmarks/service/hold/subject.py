"""The learner that is tried: `incsvr serve` as a process on a state of its own, and a client that notes all it says."""

from __future__ import annotations

import queue
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import zenoh

from benchmarks.service.bus import KEYS, PARTNERS, PATIENCE_S, process
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
        self.state, self.endpoint = state, router or free_endpoint()
        self._place = f"bus.connect={router}" if router else f"bus.listen={self.endpoint}"
        self.process: subprocess.Popen[bytes] | None = None
        self.session = open_session(client_config_at(self.endpoint), PATIENCE_S) if router else None
        self.published: dict[int, ModelSnapshot] = {}
        self.twice = 0
        self.came = threading.Condition()
        self._listening = False
        self._alive: queue.Queue[zenoh.SampleKind] = queue.Queue()

    def __enter__(self) -> Subject:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.kill()
        if self.session is not None:
            self.session.close()  # type: ignore[no-untyped-call]

    def start(self) -> float:
        """Starts it; gives how long it took until it was ready [s]."""
        began = time.monotonic()
        while not self._alive.empty():
            self._alive.get()
        words = ["--set", self._place, "--set", f"state={json_text(str(self.state))}"]
        self.process = subprocess.Popen(
            [sys.executable, "-m", "service.cli.command_line", "serve", *words],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        if self.session is None:
            self.session = open_session(client_config_at(self.endpoint), PATIENCE_S)
        if not self._listening:
            self._listening = True
            self.session.liveliness().declare_subscriber(
                KEYS.alive, lambda sample: self._alive.put(sample.kind), history=True
            )
            self.session.declare_subscriber(KEYS.model, self._note)
        self.wait_alive(zenoh.SampleKind.PUT)
        return time.monotonic() - began

    def wait_alive(self, kind: zenoh.SampleKind) -> None:
        """Waits until its liveliness says so: PUT that it is ready, DELETE that it is gone."""
        while self._alive.get(timeout=PATIENCE_S) != kind:
            pass

    def kill(self) -> None:
        """Ends it as a power cut does."""
        if self.process is not None and self.process.poll() is None:
            self.process.kill()
            self.process.wait()

    def stop(self) -> float:
        """Ends it by SIGTERM; gives how long it took [s]."""
        assert self.process is not None
        began = time.monotonic()
        self.process.terminate()
        self.process.wait(PATIENCE_S)
        return time.monotonic() - began

    def wait_for(self, revision: int) -> None:
        """Waits until a revision as high as this was published."""
        with self.came:
            if not self.came.wait_for(lambda: max(self.published, default=0) >= revision, PATIENCE_S):
                raise RuntimeError(f"revision {revision} never came")

    def ask(self, selector: str, form: type[FormType]) -> FormType | None:
        """The answer to a query, asked again until there is one; None for an error reply of the learner."""
        assert self.session is not None
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

    def wrong_answers(self, revisions: list[int]) -> tuple[int, int]:
        """How many of these published revisions are not kept, and how many are answered otherwise than published."""
        lost = wrong = 0
        for revision in revisions:
            answer = self.ask(f"{KEYS.model}?revision={revision}", ModelSnapshot)
            if answer is None:
                lost += 1
            elif not same(answer, self.published[revision]):
                wrong += 1
        return lost, wrong

    def _note(self, sample: zenoh.Sample) -> None:
        try:
            model = decode(ModelSnapshot, sample.payload.to_bytes())
        except BadInput:
            return
        with self.came:
            before = self.published.setdefault(model.revision, model)
            self.twice += not same(before, model)
            self.came.notify_all()


def same(one: Form, other: Form) -> bool:
    """Whether two snapshots hold one model; each start says it again under its own boot."""
    return one.model_dump(exclude={"boot"}) == other.model_dump(exclude={"boot"})


@contextmanager
def fed(endpoint: str, pace: float = 5.0) -> Iterator[subprocess.Popen[bytes]]:
    """Leng's run comes again and again, so many batches of samples a second, and goes on whatever happens."""
    with process(PARTNERS, "feed", endpoint, str(pace), "25") as feeder:
        yield feeder
