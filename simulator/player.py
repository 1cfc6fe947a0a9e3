"""Plays streams onto the keys of a learner at their own pace, or faster.

Every value is a message of its own, as a vehicle's drivers send them, with the vehicle's time in the payload and a
number by which the learner counts what was lost. The learner goes by the stamps alone, so the speed changes nothing but
the time it takes.
"""

from __future__ import annotations

import logging
import math
import threading
import time
from collections.abc import Callable, Mapping

import numpy as np
import zenoh

from incsvr.errors import BadInput, Failed
from incsvr.signals import REQUIRED
from service.wire import Keys
from simulator.lost_messages import health
from simulator.messages import MessageSource
from simulator.wait_for_traces import STEP_S, TraceWait

log = logging.getLogger(__name__)

MAX_SLEEP_S = 0.05
"""How long the player sleeps at most before it looks whether to stop [s]."""

NOTICE_AFTER_S = 1.0
"""Who waits for a learner says so after this time [s]; one that runs is seen in a tenth."""

COUNT_TIMEOUT_S = 2.0
"""How long the learner may take to count a message that was sent [s]; it needs a tenth."""


class Unheard(Failed):
    """The learner does not receive what is sent; the message is one sentence."""


def wait_for_learner(session: zenoh.Session, keys: Keys, patience_s: float, stop: threading.Event) -> None:
    """Returns once a learner says that it is ready.

    Raises:
        BadInput: none did within the time [s].
    """
    alive = threading.Event()
    until = time.monotonic() + patience_s
    watcher = session.liveliness().declare_subscriber(keys.alive, lambda _: alive.set(), history=True)
    told = time.monotonic() + NOTICE_AFTER_S
    try:
        while not alive.wait(MAX_SLEEP_S):
            if stop.is_set():
                return
            if time.monotonic() > told:
                log.info("waiting for the learner of %s", keys.prefix)
                told = math.inf
            if time.monotonic() > until:
                raise BadInput(f"no learner answers for {keys.prefix}; start `incsvr serve`, or play with --wait 0")
    finally:
        watcher.undeclare()  # type: ignore[no-untyped-call]


def play(
    session: zenoh.Session,
    keys: Keys,
    what: MessageSource,
    *,
    speed: float,
    stop: threading.Event,
    progress: Callable[[int, float], None] = lambda count, t: None,
    patience: TraceWait | None = None,
) -> int:
    """Sends the messages, `speed` times as fast as the vehicle did, until all are sent or `stop` is set.

    A message waits for room where the bus is slower than that; nothing is dropped on this side.

    Args:
        patience: waits for the learner after each few seconds of the vehicle's time.

    Returns:
        How many were sent.

    Raises:
        Unheard: a learner answers, but by its own counters it receives nothing of the yaw rate or of the torque. Zenoh
            drops without a word what a client may not publish.
    """
    unheard, before = set(REQUIRED) & set(what.names), _received(session, keys)
    placed = [what.key(stream, keys) for stream in range(len(what.names))]
    publishers = [
        session.declare_publisher(key, encoding=encoding, congestion_control=zenoh.CongestionControl.BLOCK)
        for key, encoding in placed
    ]
    sequence = [0] * len(publishers)
    streams = what.stream.tolist()
    began, first, sent = time.monotonic(), float(what.send[0]) if len(what) else 0.0, 0
    pause = first + STEP_S
    while sent < len(what) and not stop.is_set():
        now = first + (time.monotonic() - began) * speed
        if patience is not None:
            now = min(now, pause)
        due = int(np.searchsorted(what.send, now, side="right"))
        for index in range(sent, due):
            number = streams[index]
            publishers[number].put(what.payload(index, sequence[number]))
            sequence[number] += 1
        sent = max(sent, due)
        if before is not None and unheard:
            gone = {name for name, count in zip(what.names, sequence, strict=True) if count}
            if unheard <= gone or sent == len(what):
                _wait_until_heard(session, keys, unheard & gone, before, stop)
                unheard = set()
        progress(sent, now - first)
        if patience is not None and (now == pause or sent == len(what)):
            patience.wait(dict(zip(what.names, sequence, strict=True)))
            pause += STEP_S
        if sent < len(what):
            stop.wait(min(MAX_SLEEP_S, max(0.001, (float(what.send[sent]) - now) / speed)))
    # A question and its answer travel behind the measurements: when it is there, they have arrived.
    health(session, keys)
    for publisher in publishers:
        publisher.undeclare()  # type: ignore[no-untyped-call]
    return sent


def _received(session: zenoh.Session, keys: Keys) -> dict[str, int] | None:
    """How much of each stream the learner has received, or refused of all; None where none answers."""
    found = health(session, keys)
    if found is None:
        return None
    refused = found.counters.get("rejected", 0)
    return {name: found.streams[name].received + refused for name in REQUIRED if name in found.streams}


def _wait_until_heard(
    session: zenoh.Session, keys: Keys, names: set[str], before: Mapping[str, int], stop: threading.Event
) -> None:
    """Returns once the learner has received something of each of these streams, or no longer answers."""
    until = time.monotonic() + COUNT_TIMEOUT_S
    while not stop.is_set():
        now = _received(session, keys)
        if now is None:
            return
        missing = sorted(keys.stream(name) for name in names if now.get(name, 0) == before.get(name, 0))
        if not missing:
            return
        if time.monotonic() > until:
            raise Unheard(
                f"the learner answers but receives nothing on {' and '.join(missing)}: this client may not publish "
                "there; play in the role of the vehicle, with the vehicle.json5 of `incsvr keys` as bus.zenoh_file"
            )
        stop.wait(MAX_SLEEP_S)
