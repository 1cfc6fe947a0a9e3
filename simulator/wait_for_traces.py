"""Plays no further while the learner traces, so that what it finds does not depend on the speed of the machine.

A learner traces beside its learning. While it does, a player that goes on brings data that a slower machine has not
seen yet when the next trace begins. A patient player sends a few seconds of the vehicle's time and waits until the
learner has taken them in and nothing is at work.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from typing import Any

import zenoh

from incsvr.signals import REQUIRED
from service.bus.session import answer
from service.wire import EffectsLedger, Keys
from simulator.lost_messages import health

STEP_S = 5.0
"""Length of the vehicle's time that is played at once [s]: shorter than any trace takes beside the learner."""
LOOK_PERIOD_S = 0.04
"""Between two looks at the learner [s]; it takes its measurements in twenty times a second."""
LEARNING_QUIET_S = 0.15
"""After a whole batch has come, for so long nothing may change [s]: an iteration takes a third of it."""
MAX_WAIT_S = 120.0
"""A learner that is at work for longer is not waited for [s]: a trace takes some seconds."""


class TraceWait:
    """Waits for one learner, whose iterations learn so many samples each."""

    def __init__(self, session: zenoh.Session, keys: Keys, batch: int, stop: threading.Event) -> None:
        self._session, self._keys, self._batch, self._stop = session, keys, batch, stop
        self._before = self._received()
        self._pending = 0

    def wait(self, sent: Mapping[str, int]) -> None:
        """Returns once all that was sent, values by stream, is taken in and nothing is at work."""
        until, before, since = time.monotonic() + MAX_WAIT_S, None, time.monotonic()
        while time.monotonic() < until and not self._stop.wait(LOOK_PERIOD_S):
            now = health(self._session, self._keys)
            if now is None:
                return
            counts = {name: each.received for name, each in now.streams.items()}
            came = {name: counts.get(name, 0) - self._before.get(name, 0) for name in REQUIRED}
            whole = all(came[name] >= sent.get(name, 0) for name in REQUIRED)
            pending = now.counters.get("samples", 0) // self._batch - now.iteration
            state = (whole, counts, pending, now.iteration, self._work())
            if state != before:
                before, since = state, time.monotonic()
                continue
            quiet = LOOK_PERIOD_S if pending == self._pending else LEARNING_QUIET_S
            if whole and state[-1] is None and time.monotonic() - since >= quiet:
                self._pending = pending
                return

    def _received(self) -> dict[str, int]:
        found = health(self._session, self._keys)
        return {} if found is None else {name: each.received for name, each in found.streams.items()}

    def _work(self) -> Any:
        ledger = answer(self._session, self._keys.effects, EffectsLedger)
        return None if ledger is None else ledger.work
