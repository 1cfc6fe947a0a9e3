"""Clients that mean no good, or no longer read: junk, floods, a client that asks much and stops."""

from __future__ import annotations

import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import psutil
import zenoh

from benchmarks.service.bus import BLOCK, KEYS, PATIENCE_S, ask
from benchmarks.service.hold.row import Row
from benchmarks.service.hold.subject import Subject, fed, same
from service.bus.session import client_config_at, open_session
from service.wire import DampingReply, ModelSnapshot, measurement

FORMS = (
    b"",
    b"\xff\xfe",
    b"null",
    b"[]",
    b"{}",
    b'"t"',
    b'{"t": 1}',
    b'{"t": 1, "value": "x"}',
    b'{"t": NaN, "value": 0.1}',
    b'{"t": Infinity, "value": 0.1}',
    b'{"t": 1e12, "value": 0.1}',
    b'{"t": -1, "value": 0.1}',
    b'{"t": [1, 2], "value": [0.1]}',
    b'{"t": 1, "value": 0.1, "seq": -1}',
    b'{"t": 1, "value": 0.1, "seq": 1' + b"0" * 4299 + b"}",
    b"[" * 5000,
    b'{"t": ' + b"9" * 4300 + b', "value": 0.1}',
    b'{"t": 1, "value": 0.1}' + b" " * 2_000_000,
)
QUESTIONS = (
    "rate=1e308",
    "rate=nan",
    "rate=",
    "rate=x",
    "revision=" + "9" * 4300,
    "at=nan",
    "rate=0.1;revision=-1",
    "x=1",
)
FLOOD_VALUES = 45_000
"""Values in each message of a flood: 0.8 MB."""
STOPS = """
import sys, time
from service.bus.session import client_config_at, open_session
with open_session(client_config_at(sys.argv[1]), 30.0) as session:
    waiting = []
    for count in [50_000] * 3 + [5_000] * 40:
        payload = '{"rate": [' + ",".join(["0.123456789"] * count) + "]}"
        waiting.append(session.get("leng/yaw/damping", payload=payload.encode(), timeout=60.0))
    print("asked", flush=True)
    time.sleep(600.0)
"""


def junk(messages: int, seed: int) -> Row:
    """Messages and questions that are none, on every key; the model must stay and each message be counted."""
    random = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as state, Subject(Path(state)) as subject:
        session, before = _taught(subject)
        counted = subject.health().counters["rejected"]
        inputs = (KEYS.rate, KEYS.torque, KEYS.stream("depth"))
        began, wrong = time.monotonic(), 0
        for number in range(messages):
            form = FORMS[number] if number < len(FORMS) else _spoilt(random)
            session.put(inputs[number % len(inputs)], form, congestion_control=BLOCK)
            if number % 10 == 0:
                key = (KEYS.damping, KEYS.model, KEYS.iteration)[number // 10 % 3]
                question = QUESTIONS[number // 30 % len(QUESTIONS)]
                wrong += not list(session.get(f"{key}?{question}", timeout=PATIENCE_S))
        while (health := subject.health()).counters["rejected"] - counted < messages:
            if time.monotonic() - began > PATIENCE_S:
                break
            time.sleep(0.1)
        missed = messages - (health.counters["rejected"] - counted)
        after = subject.ask(KEYS.model, ModelSnapshot)
        wrong += after is None or not same(after, before) or health.level == "OK"
        until = [time.monotonic() - began]
    remark = "messages that health does not count; unanswered questions and changed models count as wrong"
    return Row("junk on every key", messages, max(missed, 0), wrong, until, remark)


def _spoilt(random: np.random.Generator) -> bytes:
    """A measurement with some bytes of it replaced; what is still one holds a value that no vehicle has."""
    payload = bytearray(b'{"t": 5.0, "value": 123456.0}')
    payload[int(random.integers(0, 5))] = int(random.integers(128, 256))
    return bytes(payload)


def flood(seconds: float) -> Row:
    """Arrays of 0.8 MB as fast as one client can send them, beside a stream that is learned."""
    payload = measurement(tuple((np.arange(FLOOD_VALUES) / 50.0).tolist()), (0.1,) * FLOOD_VALUES)
    with tempfile.TemporaryDirectory() as state, Subject(Path(state)) as subject:
        session, _ = _taught(subject)
        assert subject.process is not None
        learner = psutil.Process(subject.process.pid)
        before, sent, peak, waits = subject.health(), 0, 0.0, []
        with open_session(client_config_at(subject.endpoint), PATIENCE_S) as stranger:
            until = time.monotonic() + seconds
            while time.monotonic() < until:
                for _ in range(20):
                    stranger.put(KEYS.stream("depth"), payload, congestion_control=BLOCK)
                    sent += 1
                waits.append(ask(session, f"{KEYS.damping}?rate=0.1"))
                peak = max(peak, learner.memory_info().rss / 1e6)
        while True:
            health = subject.health()
            lost = health.counters.get("rejected:queue_full", 0)
            read = health.streams["depth"].received // FLOOD_VALUES
            if lost + read >= sent or time.monotonic() - until > 2.0 * PATIENCE_S:
                break
            time.sleep(0.2)
    silent = sent - lost - read
    remark = (
        f"messages of 0.8 MB that went uncounted count as wrong; memory {before.uptime_s and peak:.0f} MB at most; "
        "time that a question for the damping waits"
    )
    return Row("a flood of large arrays", sent, lost, silent, waits, remark)


def stopped_client(times: int) -> list[Row]:
    """A client asks for 50,000 rates three times and for 5,000 forty times, and is stopped before it reads."""
    waits, ends, unlearned = [], [], 0
    for _ in range(times):
        with tempfile.TemporaryDirectory() as state, Subject(Path(state)) as subject, fed(subject.endpoint):
            subject.wait_for(2)
            asks = [sys.executable, "-c", STOPS, subject.endpoint]
            with subprocess.Popen(asks, stdout=subprocess.PIPE) as client:
                assert client.stdout is not None
                client.stdout.readline()
                client.send_signal(signal.SIGSTOP)
                before = max(subject.published)
                began = time.monotonic()
                reply = subject.ask(f"{KEYS.damping}?rate=0.1", DampingReply)
                waits.append(time.monotonic() - began)
                subject.wait_for(before + 2)
                unlearned += reply is None
                ends.append(subject.stop())
                client.kill()
    return [
        Row("a client that asks much and stops", times, 0, unlearned, waits, "time that another's question waits"),
        Row("SIGTERM while such a client is there", times, 0, 0, ends, "time until the process has ended"),
    ]


def _taught(subject: Subject) -> tuple[zenoh.Session, ModelSnapshot]:
    """Has the learner learn two batches, from which nothing is on its way."""
    with fed(subject.endpoint):
        subject.wait_for(2)
    assert subject.session is not None
    before = -1
    while (samples := subject.health().counters["samples"]) != before:
        before = samples
        time.sleep(1.0)
    model = subject.ask(KEYS.model, ModelSnapshot)
    assert model is not None
    return subject.session, model
