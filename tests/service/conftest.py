"""What the tests of the bus share: real Zenoh sessions over TCP on loopback, on a free port each."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pytest
import zenoh

from service import wire
from service.bus.session import client_config_at, free_endpoint, listener_config_at, open_session
from service.config.configuration import Config
from service.config.sources import read
from service.host.host import Host
from service.host.worker_threads import WorkerThreads
from service.recordings.recording import Recording, from_table
from simulator import leng
from simulator.messages import Messages, messages
from simulator.player import play

PATIENCE = 20.0
"""How long a test waits for what must come [s]."""

FormType = TypeVar("FormType", bound=wire.Form)


@dataclass(frozen=True)
class Bench:
    """A learner on the bus, the first of its process, and a client beside it."""

    host: Host
    hosts: list[Host]
    session: zenoh.Session
    keys: wire.Keys
    stop: Callable[[], None]
    endpoint: str = ""

    def follow(self, key: str, form: type[FormType]) -> queue.Queue[FormType]:
        """A queue of the messages that are published on a key from now on."""
        found: queue.Queue[FormType] = queue.Queue()
        self.session.declare_subscriber(key, lambda sample: found.put(wire.decode(form, sample.payload.to_bytes())))
        return found

    def get(self, selector: str, payload: bytes | None = None) -> tuple[bytes | None, wire.ErrorReply | None]:
        """The answer to a query: a payload, or an error reply."""
        (reply,) = list(self.session.get(selector, payload=payload, timeout=PATIENCE))
        if reply.ok is not None:
            assert str(reply.ok.encoding) == "application/json"
            return reply.ok.payload.to_bytes(), None
        assert reply.err is not None
        return None, wire.decode(wire.ErrorReply, reply.err.payload.to_bytes())

    def health(self) -> wire.Health:
        payload, _ = self.get(self.keys.health)
        assert payload is not None
        return wire.decode(wire.Health, payload)

    def health_when(self, told: Callable[[wire.Health], bool]) -> wire.Health:
        """The first health that tells this: what was put is on its way, and what is learned takes its time."""
        until = time.monotonic() + PATIENCE
        while not told(health := self.health()):
            assert time.monotonic() < until, f"health does not come to it: {health}"
        return health

    def play(self, what: Messages | Recording, speed: float = 200.0) -> None:
        """Plays at 15,000 messages a second, which no ring loses; when this returns all has arrived."""
        if isinstance(what, Recording):
            what = messages(what.streams())
        play(self.session, self.keys, what, speed=speed, stop=threading.Event())


def cut(recording: Recording, end: float) -> Recording:
    early = recording.time < end
    return from_table(recording.name, recording.time[early], {n: v[early] for n, v in recording.columns.items()})


@pytest.fixture(scope="module")
def run() -> Recording:
    """The first two minutes of Leng's first training run: three whole batches of 50 samples."""
    return cut(leng.recording("T1", seed=7), 100.0)


def teach(session: zenoh.Session, keys: wire.Keys, seed: int, first: float, last: float) -> None:
    """Sends part of Leng's first training run, in messages that carry five seconds of a stream; nothing is dropped."""
    for start in np.arange(first, last, 5.0).tolist():
        for name, (t, value) in leng.recording("T1", seed).streams().items():
            part = (t >= start) & (t < min(start + 5.0, last))
            payload = wire.measurement(tuple(t[part].tolist()), tuple(value[part].tolist()))
            session.put(keys.stream(name), payload, congestion_control=zenoh.CongestionControl.BLOCK)


StartBench = Callable[..., Bench]


@contextmanager
def benches() -> Iterator[StartBench]:
    """Starts learners on the bus; settings are those of the configuration, with dots in the names."""
    # The clients close last: a learner that ends says goodbye to them.
    with ExitStack() as outer, ExitStack() as stack:

        def begin(**settings: Any) -> Bench:
            config = configured(**settings)
            endpoint = free_endpoint()
            server = stack.enter_context(open_session(listener_config_at(endpoint)))
            learners = config.each()
            hosts = [Host(server, each, len(learners), each.thrust_axes(learners)) for each in learners]
            crew = stack.enter_context(ExitStack())
            crew.enter_context(WorkerThreads(hosts))
            client = outer.enter_context(open_session(client_config_at(endpoint), PATIENCE))
            return Bench(hosts[0], hosts, client, hosts[0].keys, crew.close, endpoint)

        yield begin


@pytest.fixture
def start() -> Iterator[StartBench]:
    """Starts learners of this test's own."""
    with benches() as begin:
        yield begin


@pytest.fixture(scope="session")
def untaught() -> Iterator[Bench]:
    """A learner that has learned nothing, for tests that only ask."""
    with benches() as begin:
        yield begin()


@dataclass(frozen=True)
class Taught:
    """A learner with a state that has learned three batches, for tests that only ask, and what it published."""

    bench: Bench
    models: list[wire.ModelSnapshot]
    reports: list[wire.IterationReport]
    coefficients: list[wire.Coefficients]


@pytest.fixture(scope="session")
def taught(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Taught]:
    with benches() as begin:
        bench = begin(state=tmp_path_factory.mktemp("taught"))
        models = bench.follow(bench.keys.model, wire.ModelSnapshot)
        reports = bench.follow(bench.keys.iteration, wire.IterationReport)
        coefficients = bench.follow(bench.keys.coefficients, wire.Coefficients)
        bench.play(cut(leng.recording("T1", seed=7), 100.0))
        published = [[each.get(timeout=PATIENCE) for _ in range(3)] for each in (models, reports, coefficients)]
        yield Taught(bench, *published)  # type: ignore[arg-type]


def configured(**settings: Any) -> Config:
    """The defaults without durable state, changed by settings such as learner__batch=10."""
    flags: dict[str, Any] = {"state": None}
    for name, value in settings.items():
        section, _, field = name.rpartition("__")
        if section:
            flags.setdefault(section, {})[field] = value
        else:
            flags[field] = str(value) if isinstance(value, Path) else value
    return read(None, flags)
