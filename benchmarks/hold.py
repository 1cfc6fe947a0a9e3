"""What a learner survives, notices and reports: kills, restarts, junk, floods, a day of data.

Each learner is `incsvr serve` in a process of its own, on a real bus and a real disk. *Silently wrong* is an answer
that is not what was published, or a loss that health does not report.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from benchmarks.learner_process import BLOCK, KEYS, PARTNERS, PATIENCE_S, Learner, ask, fed, process, same
from benchmarks.study import Record, run, table
from service.bus.session import client_config_at, free_endpoint, open_session
from service.wire import ModelSnapshot, measurement

JUNK = (b"", b"\xff\xfe", b"null", b"{}", b'{"t": 1, "value": "x"}', b'{"t": NaN, "value": 0.1}', b"[" * 5000,
        b'{"t": 1e12, "value": 0.1}', b'{"t": [1, 2], "value": [0.1]}', b'{"t": 1, "value": 0.1, "seq": -1}',
        b'{"t": ' + b"9" * 4300 + b', "value": 0.1}', b'{"t": 1, "value": 0.1}' + b" " * 2_000_000)  # fmt: skip
QUESTIONS = ("rate=1e308", "rate=nan", "rate=", "revision=" + "9" * 4300, "at=nan", "rate=0.1;revision=-1", "x=1")
FLOOD_VALUES = 45_000
"""Values in each message of a flood: 0.8 MB."""
BATCHES_PER_S = 20.0
"""Batches of samples a second in the day: ten minutes of the vehicle each second."""


def row(what: str, tried: int, lost: int, wrong: int, until: Sequence[float], about: str) -> Record:
    """What was tried how often, what is lost and reported, what is silently wrong, and the seconds until it was over
    or reported of each try."""
    return {"what": what, "tried": tried, "lost": lost, "wrong": int(wrong), "until": list(until), "about": about}


def kills(times: int, seed: int, state: Path) -> Record:
    """Kills a learner that learns five batches a second, and asks the next one for what was published."""
    random, lost, wrong, until = np.random.default_rng(seed), 0, 0, []
    with Learner(state) as subject, fed(subject.endpoint):
        subject.note()
        for _ in range(times):
            subject.wait_for(1)
            time.sleep(random.uniform(0.0, 0.4))
            subject.kill()
            newest = subject.newest
            until.append(subject.start())
            served = subject.ask(KEYS.model, ModelSnapshot)
            lost += served is None or served.revision < newest  # one more may have been saved and not sent
            wrong += served is not None and served.revision == newest and not same(served, subject.published[newest])
            received = sorted(subject.published)[-10:]  # one that was saved and not sent is in no client
            missing, otherwise = subject.wrong_answers(each for each in received if each <= newest)
            lost, wrong = lost + missing, wrong + otherwise
        about = f"of {subject.newest} published revisions those unknown after the start; time until it is ready"
        return row("kill -9 at a random moment, and a start", times, lost, wrong + subject.twice, until, about)


def restarts(times: int, seed: int, state: Path) -> Record:
    """A router and its client, the learner, restart in turn under a running stream; the next iteration must come."""
    endpoint, until = free_endpoint(), []
    with ExitStack() as stack, ExitStack() as router:
        router.enter_context(process(PARTNERS, "router", endpoint))
        subject = stack.enter_context(Learner(state, router=endpoint))
        subject.note()
        stack.enter_context(fed(endpoint))
        for turn in range(times):
            subject.wait_for(1)
            began = time.monotonic()
            if turn % 2:
                subject.stop()
                subject.start()
            else:
                router.close()
                router.enter_context(process(PARTNERS, "router", endpoint))
            subject.wait_for(1)
            until.append(time.monotonic() - began)
        lost, wrong = subject.wrong_answers(sorted(subject.published))
        about = f"of {len(subject.published)} published revisions; time until the next iteration"
        return row("router or learner restarted under a stream", times, lost, wrong + subject.twice, until, about)


def junk(times: int, seed: int, state: Path) -> Record:
    """Messages and questions that are none, on every key; the model must stay and each message be counted."""
    random = np.random.default_rng(seed)
    with Learner(state) as subject:
        before, counted = _taught(subject), subject.health().counters["rejected"]
        began, wrong, inputs = time.monotonic(), 0, (KEYS.rate, KEYS.torque, KEYS.stream("depth"))
        for number in range(times):
            spoilt = bytearray(b'{"t": 5.0, "value": 123456.0}')
            spoilt[int(random.integers(0, 5))] = int(random.integers(128, 256))
            form = JUNK[number] if number < len(JUNK) else bytes(spoilt)
            subject.session.put(inputs[number % 3], form, congestion_control=BLOCK)
            if number % 10 == 0:
                key = (KEYS.damping, KEYS.model, KEYS.iteration)[number // 10 % 3]
                question = QUESTIONS[number // 30 % len(QUESTIONS)]
                wrong += not list(subject.session.get(f"{key}?{question}", timeout=PATIENCE_S))
        until = time.monotonic() + PATIENCE_S
        while (rejected := subject.health().counters["rejected"] - counted) < times and time.monotonic() < until:
            time.sleep(0.1)
        after = subject.ask(KEYS.model, ModelSnapshot)
        wrong += after is None or not same(after, before)
        about = "messages that health does not count; unanswered questions and changed models are wrong"
        return row("junk on every key", times, max(times - rejected, 0), wrong, [time.monotonic() - began], about)


def flood(times: int, seed: int, state: Path) -> Record:
    """Arrays of 0.8 MB as fast as one client can send them, for so many seconds."""
    payload = measurement(tuple((np.arange(FLOOD_VALUES) / 50.0).tolist()), (0.1,) * FLOOD_VALUES)
    with Learner(state) as subject:
        _taught(subject)
        sent, peak, waits = 0, 0.0, list[float]()
        with open_session(client_config_at(subject.endpoint), PATIENCE_S) as stranger:
            until = time.monotonic() + times
            while time.monotonic() < until:
                for _ in range(20):
                    stranger.put(KEYS.stream("depth"), payload, congestion_control=BLOCK)
                sent += 20
                waits.append(ask(subject.session, f"{KEYS.damping}?rate=0.1"))
                peak = max(peak, subject.resident_mb())
        known, lost = 0, 0
        while known < sent and time.monotonic() < until + 2.0 * PATIENCE_S:
            health = subject.health()
            lost = health.counters.get("rejected:queue_full", 0)
            known = lost + health.streams["depth"].received // FLOOD_VALUES
        about = f"messages; uncounted ones are wrong; {peak:.0f} MB at most; time that a damping question waits"
        return row(f"a flood of arrays of 0.8 MB, {times} s", sent, lost, sent - known, waits, about)


def day(times: int, seed: int, state: Path) -> Record:
    """So many hours of data at top speed: the learner's memory, and what it loses."""
    with Learner(state) as subject, fed(subject.endpoint, BATCHES_PER_S):
        subject.note()
        memory = list[float]()
        subject.wait_for(1)
        began, first = time.monotonic(), subject.health().t or 0.0
        while ((health := subject.health()).t or 0.0) - first < 3600.0 * times:
            memory.append(subject.resident_mb())
            time.sleep(1.0)
        third = max(len(memory) // 3, 1)
        means = [float(np.mean(part)) for part in (memory[third : 2 * third] or memory, memory[2 * third :] or memory)]
        about = f"samples; {health.iteration} iterations in {time.monotonic() - began:.0f} s; mean memory in the "
        about += f"second and last third {means[0]:.1f} and {means[1]:.1f} MB, {max(memory):.0f} MB at most"
        wrong = health.level not in ("OK", "WARN")
        return row(f"{times} h of data at top speed", 1, health.counters["rejected"], wrong, [], about)


def _taught(subject: Learner) -> ModelSnapshot:
    """Has the learner learn two batches, from which nothing is on its way; its model."""
    subject.note()
    with fed(subject.endpoint):
        subject.wait_for(2)
    before = -1
    while (samples := subject.health().counters["samples"]) != before:
        before = samples
        time.sleep(1.0)
    model = subject.ask(KEYS.model, ModelSnapshot)
    assert model is not None
    return model


TRIES: dict[str, tuple[Callable[[int, int, Path], Record], int]] = {
    "kills": (kills, 200), "restarts": (restarts, 100), "junk": (junk, 10_000),
    "flood": (flood, 30), "day": (day, 24),
}  # fmt: skip
"""By name, with how often."""


def cases(asked: argparse.Namespace) -> list[tuple[str, int, int]]:
    return [(name, max(round(asked.part * count), 1), asked.seed) for name, (_, count) in TRIES.items()
            if asked.only in name]  # fmt: skip


def examine(case: tuple[str, int, int]) -> Record:
    with tempfile.TemporaryDirectory() as state:
        return TRIES[case[0]][0](case[1], case[2], Path(state))


def report(results: Sequence[Record]) -> Iterator[str]:
    head = ["what", "tried", "lost, and reported", "silently wrong", "seconds: median, most", "what is counted"]
    times = {each["what"]: f"{np.median(each['until']):.2f}, {max(each['until']):.2f}" for each in results
             if each["until"]}  # fmt: skip
    yield table(head, [[each["what"], each["tried"], each["lost"], each["wrong"], times.get(each["what"], "–"),
                        each["about"]] for each in results])  # fmt: skip


def main(words: Sequence[str] | None = None) -> None:
    run("hold", __doc__, cases, examine, report, words, ("eclipse-zenoh",), part=(1.0, "of the tries"),
        seed=(0, "of moments and places"), only=("", "part of a try's name"))  # fmt: skip


if __name__ == "__main__":
    main()
