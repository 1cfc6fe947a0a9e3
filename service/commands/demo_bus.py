"""The demo as a client of its learner: subscriptions and queries."""

from __future__ import annotations

import queue
import subprocess
import time
from collections.abc import Iterator

import zenoh

from incsvr.errors import Failed
from service.bus.session import answer
from service.commands.demo_processes import START_TIMEOUT_S
from service.wire import FormType, Health, IterationHistory, IterationReport, Keys, decode

KEYS = Keys("leng/yaw")


def arriving(session: zenoh.Session, key: str, form: type[FormType]) -> queue.Queue[FormType]:
    """A queue of the messages that are published on a key from now on."""
    arrivals: queue.Queue[FormType] = queue.Queue()
    session.declare_subscriber(key, lambda sample: arrivals.put(decode(form, sample.payload.to_bytes())))
    return arrivals


def learner_answer(session: zenoh.Session, selector: str, form: type[FormType]) -> FormType:
    """The learner's answer.

    Raises:
        Failed: it does not answer.
    """
    found = answer(session, selector, form)
    if found is None:
        raise Failed(f"the learner does not answer for {selector}; see serve.log")
    return found


def iterations(
    session: zenoh.Session,
    reports: queue.Queue[IterationReport],
    player: subprocess.Popen[bytes],
    learner: subprocess.Popen[bytes],
) -> Iterator[IterationReport]:
    """The reports as they come, until the simulator has played everything and all that was learned has come."""
    revision = 0
    while True:
        try:
            report = reports.get(timeout=0.2)
            if report.revision > revision:
                revision = report.revision
                yield report
        except queue.Empty:
            if learner.poll() is not None:
                raise Failed("the learner ended; see serve.log") from None
            if player.poll() not in (None, 0):
                raise Failed("the simulator failed; see simulate.log") from None
            if player.poll() == 0:
                # All that was played has arrived; every whole batch of it becomes an iteration.
                health = learner_answer(session, KEYS.health, Health)
                if health.iteration >= health.counters["samples"] // 50:
                    # This answer may have overtaken the last report: each has a thread of its own in Zenoh's binding.
                    yield from learner_answer(
                        session, f"{KEYS.iteration}?after={revision}", IterationHistory
                    ).iterations
                    return


def wait_until_alive(session: zenoh.Session, learner: subprocess.Popen[bytes]) -> None:
    """Returns once the learner says that it is ready.

    Raises:
        Failed: it ended, or did not say so in time.
    """
    alive: queue.Queue[bool] = queue.Queue()
    session.liveliness().declare_subscriber(KEYS.alive, lambda _: alive.put(True), history=True)
    until = time.monotonic() + START_TIMEOUT_S
    while time.monotonic() < until and learner.poll() is None:
        try:
            alive.get(timeout=0.2)
            return
        except queue.Empty:
            continue
    raise Failed("the learner did not start; see serve.log")
