"""What clients may ask of the bus and of the learner: bounded, answered as asked, and never at another's cost."""

from __future__ import annotations

import queue
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import pytest
import zenoh

from incsvr.errors import BadInput
from service import wire
from service.bus.session import client_config_at, free_endpoint, open_session, take_prefix
from tests.service.commands.test_processes import KEYS, client, client_after, command, following, serving
from tests.service.conftest import PATIENCE, StartBench, teach


def test_a_revision_is_answered_as_it_was_or_said_to_be_gone(start: StartBench, tmp_path: Path) -> None:
    bench = start(state=tmp_path, history=2)
    models = bench.follow(bench.keys.model, wire.ModelSnapshot)
    reports = bench.follow(bench.keys.iteration, wire.IterationReport)
    teach(bench.session, bench.keys, 2, 0.0, 100.0)
    published = [models.get(timeout=PATIENCE) for _ in range(3)]
    told = [reports.get(timeout=PATIENCE) for _ in range(3)]
    for asked in ("revision=2", f"at={published[1].t}"):
        answer, _ = bench.get(f"{bench.keys.iteration}?{asked}")
        assert answer is not None
        assert wire.decode(wire.IterationReport, answer) == told[1]
        answer, _ = bench.get(f"{bench.keys.damping}?rate=0.1,-0.2;{asked}")
        assert answer is not None
        then = wire.decode(wire.DampingReply, answer)
        assert (then.revision, then.iteration, then.rate) == (2, 2, (0.1, -0.2))
        assert then.damping == tuple(published[1].model.predict([0.1, -0.2]).damping)
    for question in ("iteration?revision=1", "damping?rate=0.1;revision=1", "model?revision=1"):
        answer, error = bench.get(f"{bench.keys.prefix}/{question}")
        assert answer is None
        assert error is not None
        assert error.error_type == "NotKept"
        assert error.error == "revision 1 is not kept; the latest is 3"


STOPPED = """
import sys, time
from service.bus.session import client_config_at, open_session
with open_session(client_config_at(sys.argv[1]), 20.0) as session:
    waiting = []
    for count in [50_000] * 3 + [5_000] * 40:
        payload = '{"rate": [' + ",".join(["0.123456789"] * count) + "]}"
        waiting.append(session.get("leng/yaw/damping", payload=payload.encode(), timeout=60.0))
    print("asked", flush=True)
    time.sleep(600.0)
"""


@contextmanager
def a_client_that_asks_and_stops(endpoint: str) -> Iterator[None]:
    with subprocess.Popen([sys.executable, "-c", STOPPED, endpoint], stdout=subprocess.PIPE) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == b"asked\n"
            process.send_signal(signal.SIGSTOP)
            yield
        finally:
            process.kill()


@pytest.mark.slow
def test_a_client_that_asks_much_and_stops_holds_up_nobody(tmp_path: Path) -> None:
    endpoint = free_endpoint()
    with client_after(endpoint, tmp_path) as (process, session, alive):
        models = following(session)
        teach(session, KEYS, 9, 0.0, 40.0)
        assert models.get(timeout=PATIENCE).revision == 1
        with a_client_that_asks_and_stops(endpoint):
            began = time.monotonic()
            for question in (f"{KEYS.damping}?rate=0.1", KEYS.health):
                (reply,) = list(session.get(question, timeout=PATIENCE))
                assert reply.ok is not None
            teach(session, KEYS, 9, 40.0, 70.0)
            assert models.get(timeout=PATIENCE).revision == 2
            assert time.monotonic() - began < 4.0
            began = time.monotonic()
            process.send_signal(signal.SIGTERM)
            assert "DELETE" in alive.get(timeout=PATIENCE)
            assert process.wait(PATIENCE) == 0
            assert time.monotonic() - began < 4.0  # the unit allows five


@pytest.mark.slow
def test_a_second_learner_of_the_same_prefix_refuses_and_says_so(tmp_path: Path) -> None:
    endpoint = free_endpoint()
    with client_after(endpoint, tmp_path / "first") as (_, session, _):
        second = command("serve", "--set", f"bus.connect={endpoint}", "--set", f"state={tmp_path / 'second'}")
        done = subprocess.run(second, capture_output=True, text=True, check=False, timeout=60.0)
        assert done.returncode == 2
        assert "another learner has the prefix leng/yaw on this bus" in done.stderr
        assert "Traceback" not in done.stderr
        heard: queue.Queue[wire.Health] = queue.Queue()
        session.declare_subscriber(
            KEYS.health, lambda sample: heard.put(wire.decode(wire.Health, sample.payload.to_bytes()))
        )
        with subprocess.Popen([*second, "--set", "bus.allow_second=true"], stderr=subprocess.DEVNULL) as learner:
            try:
                saying: set[str] = set()
                until = time.monotonic() + PATIENCE
                while len(saying) < 2:  # both say so
                    health = heard.get(timeout=max(until - time.monotonic(), 0.0))
                    if any("publishes under the same prefix" in reason for reason in health.reasons):
                        saying.add(health.boot)
            finally:
                learner.kill()


@pytest.mark.slow
def test_a_learner_that_comes_back_is_not_taken_for_another_one(tmp_path: Path) -> None:
    """The router that both its lives are clients of forgets the first one in time."""
    endpoint = free_endpoint()
    router = zenoh.Config.from_json5('{mode: "router", scouting: {multicast: {enabled: false}}}')
    router.insert_json5("listen/endpoints", f'["{endpoint}"]')
    words = ["--set", f"bus.connect={endpoint}"]
    with open_session(router), client(endpoint) as (_, alive):
        for _ in range(2):
            with serving(free_endpoint(), tmp_path, *words):
                assert "PUT" in alive.get(timeout=PATIENCE)
            assert "DELETE" in alive.get(timeout=PATIENCE)


LEARNERS = 3


def router(endpoint: str) -> zenoh.Config:
    config = zenoh.Config.from_json5('{mode: "router", scouting: {multicast: {enabled: false}}}')
    config.insert_json5("listen/endpoints", f'["{endpoint}"]')
    return config


@pytest.mark.slow
def test_of_several_that_start_in_the_same_moment_exactly_one_stays() -> None:
    endpoint, together = free_endpoint(), threading.Barrier(LEARNERS)

    def come(session: zenoh.Session) -> object:
        together.wait()
        try:
            return take_prefix(session, "leng/yaw", threading.Event(), hub=True)
        except BadInput as refusal:
            return str(refusal)

    with open_session(router(endpoint)):
        sessions = [open_session(client_config_at(endpoint)) for _ in range(LEARNERS)]
        try:
            with ThreadPoolExecutor(LEARNERS) as threads:
                outcomes = list(threads.map(come, sessions))
            refused = [outcome for outcome in outcomes if isinstance(outcome, str)]
            assert len(refused) == LEARNERS - 1
            assert all("another learner has the prefix leng/yaw" in sentence for sentence in refused)
        finally:
            for session in sessions:
                session.close()  # type: ignore[no-untyped-call]
