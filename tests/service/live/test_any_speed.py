"""The ledger of a replay is the same to the byte, however quickly the data come and however long a trace takes."""

from __future__ import annotations

import time
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
import zenoh

from incsvr.errors import BadInput
from incsvr.numerics import Streams
from service import wire
from service.bus.session import free_endpoint, listener_config_at, open_session
from service.host.host import Host
from service.learner.node import LearnerNode
from service.live.live_tracing import LiveTracing
from service.recordings.recording import Recording
from simulator import leng
from tests.service.conftest import configured, cut
from tests.service.live.test_live_tracing import INERTIA, TRACED_S
from tests.worlds import trial

ADVISE: dict[str, Any] = {"tracing__live": "advise", "tracing__window": 120.0, "tracing__proof": 40.0}


@dataclass
class Slow:
    """A process beside that ends when it is told to, and finds nothing."""

    has_ended: bool = False

    def answer(self) -> Any:
        raise BadInput("nothing is found here")

    def close(self) -> None:
        pass


@dataclass
class Desk:
    """Where the work of slow processes is noted: what it is, and a check of the data that it is given."""

    jobs: list[tuple[str, float, int]] = field(default_factory=list)
    at_work: Slow = field(default_factory=Slow)

    def begin(self, job: Mapping[str, Any], streams: Streams) -> Slow:
        data = b"".join(name.encode() + t.tobytes() + value.tobytes() for name, (t, value) in sorted(streams.items()))
        self.jobs.append((job["work"], float(streams["yaw_rate"][0][-1]), zlib.crc32(data)))
        self.at_work = Slow()
        return self.at_work


def jobs(run: Recording, batches_at_work: int) -> list[tuple[str, float, int]]:
    """What is traced of a recording where each trace takes so many batches."""
    desk, node = Desk(), LearnerNode(configured(**ADVISE), boot="")
    live, waited = LiveTracing(node.config, None, desk.begin), 0
    for start in np.arange(0.0, float(run.time[-1]), 5.0).tolist():
        for name, (t, value) in run.streams().items():
            part = (t >= start) & (t < start + 5.0)
            node.push(name, t[part], value[part])
        while node.learn() is not None:
            pass
        live.after(node)
        while live.work is not None and waited >= batches_at_work:
            desk.at_work.has_ended, waited = True, 0
            live.conclude(node)
            live.after(node)
        waited += 1
    return desk.jobs


def test_what_is_traced_does_not_depend_on_how_long_a_trace_takes() -> None:
    run = cut(leng.recording("T1", 7), 395.0)
    prompt = jobs(run, 0)
    assert len(prompt) >= 8
    assert [end for _, end, _ in prompt] == sorted({end for _, end, _ in prompt})
    slow = jobs(run, 7)
    assert len(slow) >= 6
    assert slow == prompt[: len(slow)]


@pytest.mark.parametrize("mode", ["off", "advise"])
def test_the_ends_of_batches_are_kept_for_a_tracer_alone(mode: str) -> None:
    node = LearnerNode(configured(**ADVISE | {"tracing__live": mode}), boot="")
    for name, (t, value) in cut(leng.recording("T1", 7), 100.0).streams().items():
        node.push(name, t, value)
    while node.learn() is not None:
        pass
    assert [end.served.revision for end in node.take_batch_ends()] == ([1, 2, 3] if mode == "advise" else [])
    assert node.take_batch_ends() == []


@pytest.fixture(scope="module")
def session() -> Iterator[zenoh.Session]:
    with open_session(listener_config_at(free_endpoint())) as opened:
        yield opened


OWN = ("yaw_rate", "torque")


def ledger_of(session: zenoh.Session, run: Recording, prefix: str, part_s: float) -> bytes:
    """The ledger after a replay in which so much of the vehicle's time comes at once [s]."""
    config = configured(
        prefix=prefix, vehicle__inertia=INERTIA, vehicle__rate_range=[-0.35, 0.35], tracing__live="advise",
        tracing__window=240.0, tracing__proof=60.0,
    )  # fmt: skip
    host = Host(session, config)
    try:
        for start in np.arange(0.0, float(run.time[-1]), part_s).tolist():
            for name, (t, value) in run.streams().items():
                for first in np.arange(start, start + part_s, 5.0).tolist():
                    part = (t >= first) & (t < min(first + 5.0, start + part_s))
                    payload = wire.measurement(tuple(t[part].tolist()), tuple(value[part].tolist()))
                    if part.any():
                        session.put(host.keys.stream(name), payload, congestion_control=zenoh.CongestionControl.BLOCK)
            sent = {name: int(np.count_nonzero(t < start + part_s)) for name, (t, _) in run.streams().items()}
            until, received = time.monotonic() + TRACED_S, dict[str, int]()
            while host.learn() or host.node.ledger.work is not None or any(received.get(n, 0) < sent[n] for n in OWN):
                host.feed.drain()
                received = {name: each.received for name, each in host.watch.report(host.node).streams.items()}
                assert time.monotonic() < until
                time.sleep(0.01)
        return wire.encode(host.node.ledger)
    finally:
        host.close()


@pytest.mark.slow
def test_a_replay_gives_the_same_ledger_at_two_speeds(session: zenoh.Session) -> None:
    run = cut(trial(1, ("torque_lag",), duration=700.0).recording, 380.0)
    patient, at_once = ledger_of(session, run, "slow/yaw", 10.0), ledger_of(session, run, "quick/yaw", 380.0)
    found = wire.decode(wire.EffectsLedger, patient)
    assert [step["step"] for step in found.history][:2] == ["suspected", "proven"]
    assert at_once == patient
