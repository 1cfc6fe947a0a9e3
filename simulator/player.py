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
from collections.abc import Callable

import numpy as np
import zenoh

from incsvr.errors import BadInput
from incsvr.signals import REQUIRED
from service.recordings.archive_reader import ArchiveReader
from service.wire import Keys
from simulator.intake import Intake
from simulator.messages import Messages

log = logging.getLogger(__name__)

MAX_SLEEP_S = 0.05
"""How long the player sleeps at most before it looks whether to stop [s]."""

NOTICE_AFTER_S = 1.0
"""Who waits for a learner says so after this time [s]; one that runs is seen in a tenth."""

PATIENT_STEP_S = 5.0
"""Length of the vehicle's time that is played at once [s]: shorter than any trace takes beside the learner."""


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
    what: Messages | ArchiveReader,
    *,
    speed: float,
    stop: threading.Event,
    second: Callable[[], None] = lambda: None,
    intake: Intake | None = None,
    patient: bool = False,
) -> int:
    """Sends the messages, `speed` times as fast as the vehicle did, until all are sent or `stop` is set.

    A message waits for room where the bus is slower than that; nothing is dropped on this side.

    Args:
        second: called after each second of the vehicle's time.
        intake: of the learner; None for one that begins now.
        patient: waits for the learner after each few seconds of the vehicle's time.

    Returns:
        How many were sent.

    Raises:
        Unheard: a learner answers, but it receives nothing of the yaw rate or of the torque.
    """
    intake = intake or Intake(session, keys, stop)
    placed = [what.key(stream, keys) for stream in range(len(what.names))]
    places = {key: place for place, (key, _) in enumerate(placed)}
    own = {name: places[key] for name in REQUIRED if (key := keys.stream(name)) in places}
    unheard = set(own)
    publishers = [
        session.declare_publisher(key, encoding=encoding, congestion_control=zenoh.CongestionControl.BLOCK)
        for key, encoding in placed
    ]
    sequence = [0] * len(publishers)
    streams = what.stream.tolist()
    began, first, sent = time.monotonic(), float(what.send[0]) if len(what) else 0.0, 0
    passed, pause = 0, first + PATIENT_STEP_S if patient else math.inf
    while sent < len(what) and not stop.is_set():
        now = min(first + (time.monotonic() - began) * speed, pause)
        due = int(np.searchsorted(what.send, now, side="right"))
        for index in range(sent, due):
            number = streams[index]
            publishers[number].put(what.payload(index, sequence[number]))
            sequence[number] += 1
        sent = max(sent, due)
        gone = {name: sequence[place] for name, place in own.items()}
        if unheard and (sent == len(what) or all(gone[name] for name in unheard)):
            intake.check([name for name in unheard if gone[name]])
            unheard = set()
        reached = int(min(now, float(what.send[-1])) - first)
        for _ in range(passed, reached):
            second()
        passed = max(passed, reached)
        if patient and (now == pause or sent == len(what)):
            intake.settled(gone)
            pause += PATIENT_STEP_S
        if sent < len(what):
            stop.wait(min(MAX_SLEEP_S, max(0.001, (float(what.send[sent]) - now) / speed)))
    # A question and its answer travel behind the measurements: when it is there, they have arrived.
    intake.health()
    for publisher in publishers:
        publisher.undeclare()  # type: ignore[no-untyped-call]
    return sent
