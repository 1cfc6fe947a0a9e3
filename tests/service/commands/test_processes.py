"""`incsvr serve` as a process: how it starts, ends, dies and comes back."""

from __future__ import annotations

import queue
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path

import pytest
import zenoh

from service import wire
from service.bus.session import client_config_at, free_endpoint, open_session
from simulator import leng
from simulator.messages import messages
from simulator.player import play
from tests.service.conftest import PATIENCE, teach

KEYS = wire.Keys("leng/yaw")


def command(*words: str) -> list[str]:
    return [sys.executable, "-m", "service.cli.command_line", *words]


@contextmanager
def serving(endpoint: str, state: Path, *words: str) -> Iterator[subprocess.Popen[bytes]]:
    process = subprocess.Popen(
        command("serve", "--listen", endpoint, "--set", f"state={state}", *words), stderr=subprocess.PIPE
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()
        assert process.stderr is not None
        process.stderr.close()


@pytest.fixture
def endpoint() -> str:
    return free_endpoint()


@contextmanager
def client(endpoint: str) -> Iterator[tuple[zenoh.Session, queue.Queue[str]]]:
    """A session, and what its learner's liveliness says."""
    alive: queue.Queue[str] = queue.Queue()
    with open_session(client_config_at(endpoint), PATIENCE) as session:
        session.liveliness().declare_subscriber(KEYS.alive, lambda sample: alive.put(str(sample.kind)), history=True)
        yield session, alive


def next_model(models: queue.Queue[wire.ModelSnapshot]) -> wire.ModelSnapshot:
    return models.get(timeout=PATIENCE)


def answered(session: zenoh.Session, selector: str) -> wire.ModelSnapshot:
    (reply,) = list(session.get(selector, timeout=PATIENCE))
    assert reply.ok is not None
    return wire.decode(wire.ModelSnapshot, reply.ok.payload.to_bytes())


def taken_until(session: zenoh.Session, t: float) -> None:
    """Asks until the learner has both streams up to the time t [s]: what is still on the wire would be lost."""
    until = time.monotonic() + PATIENCE
    while True:
        (reply,) = list(session.get(KEYS.health, timeout=PATIENCE))
        assert reply.ok is not None
        streams = wire.decode(wire.Health, reply.ok.payload.to_bytes()).streams
        newest = [streams[name].t or 0.0 for name in ("yaw_rate", "torque")]
        if min(newest) >= t:
            return
        assert time.monotonic() < until, f"{newest} of {t} s have come"


def following(session: zenoh.Session) -> queue.Queue[wire.ModelSnapshot]:
    models: queue.Queue[wire.ModelSnapshot] = queue.Queue()
    session.declare_subscriber(
        KEYS.model, lambda sample: models.put(wire.decode(wire.ModelSnapshot, sample.payload.to_bytes()))
    )
    return models


def test_it_is_ready_soon_ends_soon_and_says_goodbye(endpoint: str, tmp_path: Path) -> None:
    with serving(endpoint, tmp_path) as process, client(endpoint) as (_, alive):
        assert "PUT" in alive.get(timeout=PATIENCE)
        began = time.monotonic()
        process.send_signal(signal.SIGTERM)
        assert "DELETE" in alive.get(timeout=PATIENCE)
        assert process.wait(PATIENCE) == 0
        assert time.monotonic() - began < 1.0


def test_after_kill_9_it_goes_on_after_the_last_published_revision(endpoint: str, tmp_path: Path) -> None:
    with client_after(endpoint, tmp_path) as (process, session, alive):
        models = following(session)
        teach(session, KEYS, 9, 0, 70)
        before = [next_model(models), next_model(models)]
        process.send_signal(signal.SIGKILL)
        assert process.wait(PATIENCE) == -signal.SIGKILL
        assert "DELETE" in alive.get(timeout=PATIENCE)
        with serving(endpoint, tmp_path):
            assert "PUT" in alive.get(timeout=PATIENCE)
            resumed = answered(session, KEYS.model)
            assert replace(resumed, boot="") == replace(before[-1], boot="")
            assert resumed.boot != before[-1].boot
            teach(session, KEYS, 9, 70, 140)
            after = next_model(models)
            if after.boot == resumed.boot and after.revision == resumed.revision:
                after = next_model(models)  # what it resumes from is said again to whoever listens by then
            assert (after.revision, after.iteration) == (3, 3)
            assert answered(session, f"{KEYS.model}?revision=1") == before[0]


@contextmanager
def client_after(
    endpoint: str, state: Path, *words: str
) -> Iterator[tuple[subprocess.Popen[bytes], zenoh.Session, queue.Queue[str]]]:
    """A learner that is ready, and a client of it."""
    with serving(endpoint, state, *words) as process, client(endpoint) as (session, alive):
        assert "PUT" in alive.get(timeout=PATIENCE)
        yield process, session, alive


@pytest.mark.slow
def test_stopped_and_started_in_between_it_publishes_the_same(endpoint: str, tmp_path: Path) -> None:
    """SIGTERM saves also what is on its way to the next batch."""
    with client_after(endpoint, tmp_path / "whole") as (_, session, _alive):
        models = following(session)
        teach(session, KEYS, 9, 0, 100)
        whole = [next_model(models) for _ in range(3)]
    with client_after(endpoint, tmp_path / "halves") as (process, session, alive):
        models = following(session)
        teach(session, KEYS, 9, 0, 45)
        first = next_model(models)
        taken_until(session, 44.9)
        process.send_signal(signal.SIGTERM)
        assert process.wait(PATIENCE) == 0
        assert "DELETE" in alive.get(timeout=PATIENCE)
        with serving(endpoint, tmp_path / "halves"):
            assert "PUT" in alive.get(timeout=PATIENCE)
            teach(session, KEYS, 9, 45, 100)
            again = next_model(models)
            if again.revision == 1:  # what it had is published once more; we may be connected in time to see it
                again = next_model(models)
            halves = [first, again, next_model(models)]
    for one, other in zip(whole, halves, strict=True):
        assert replace(one, boot="") == replace(other, boot="")


def test_told_to_stop_while_it_waits_for_its_router_it_ends_without_an_error(tmp_path: Path) -> None:
    words = ["serve", "--set", f"bus.connect={free_endpoint()}", "--set", f"state={tmp_path}"]
    with subprocess.Popen(
        [sys.executable, "-m", "service.cli.command_line", *words], stderr=subprocess.PIPE, text=True
    ) as learner:
        assert learner.stderr is not None
        assert "waiting for the bus" in learner.stderr.readline()
        learner.send_signal(signal.SIGTERM)
        assert learner.stderr.read() == ""
        assert learner.wait(PATIENCE) == 0


@pytest.mark.slow
def test_query_says_clearly_when_nobody_answers_and_waits_for_a_learner(endpoint: str, tmp_path: Path) -> None:
    nobody = subprocess.run(
        command("query", "0.1", "--connect", endpoint, "--wait", "0.3"), capture_output=True, text=True, check=False
    )
    assert nobody.returncode == 1
    assert f"no bus answers at {endpoint}" in nobody.stderr
    waiting = subprocess.Popen(
        command("query", "0.1", "-0.2", "--connect", endpoint, "--wait", "20", "--json", "-"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    with ExitStack() as stack:
        stack.enter_context(waiting)
        stack.callback(waiting.kill)
        _, session, _ = stack.enter_context(client_after(endpoint, tmp_path))
        teach(session, KEYS, 9, 0, 40)
        out, said = waiting.communicate(timeout=PATIENCE)
    assert waiting.returncode == 0, said
    reply = wire.decode(wire.DampingReply, out)
    assert reply.rate == (0.1, -0.2)
    assert reply.damping[0] > 0.0 > reply.damping[1]
    assert b"damping [N m]" in said


@pytest.mark.slow
def test_a_player_and_a_learner_find_each_other_in_any_order(endpoint: str, tmp_path: Path) -> None:
    """The learner may come later, and may be restarted: the client comes back by itself."""
    with serving(endpoint, tmp_path) as process, client(endpoint) as (session, alive):
        assert "PUT" in alive.get(timeout=PATIENCE)
        process.kill()
        process.wait()
        assert "DELETE" in alive.get(timeout=PATIENCE)
        with serving(endpoint, tmp_path):
            assert "PUT" in alive.get(timeout=PATIENCE)
            models = following(session)
            streams = leng.recording("T1", seed=9).streams()
            short = {name: (t[t < 40.0], value[t < 40.0]) for name, (t, value) in streams.items()}
            play(session, KEYS, messages(short), speed=1e6, stop=threading.Event())
            assert next_model(models).iteration == 1


def test_a_signal_while_the_event_is_locked_is_heard() -> None:
    """It comes in the middle of the main thread's own wait, which holds the event's lock."""
    unlucky = (
        "import signal\n"
        "from service.bus.session import stop_event\n"
        "stop = stop_event()\n"
        "with stop._cond:\n"
        "    signal.raise_signal(signal.SIGTERM)\n"
        "assert stop.wait(10.0)\n"
    )
    subprocess.run([sys.executable, "-c", unlucky], check=True, timeout=30.0)
