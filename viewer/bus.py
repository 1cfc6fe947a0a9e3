"""The learner's bus as viewer and page hear it: what the learner knows is asked for, streams are subscribed to."""

from __future__ import annotations

import logging
import time
from collections import deque
from collections.abc import Iterator
from typing import Any

import zenoh
from zenoh.handlers import Callback

from incsvr.errors import BadInput
from service.bus.session import answer
from service.wire import (
    EffectsLedger,
    FormType,
    Health,
    IterationHistory,
    IterationReport,
    Keys,
    Measurement,
    ModelSnapshot,
    decode,
)

log = logging.getLogger(__name__)


class Questions:
    """What one learner answers, None where it does not; it answers within a hundredth of a second while it trains.

    Each raises BadInput where what answers is no learner of this version.
    """

    def __init__(self, session: zenoh.Session, keys: Keys) -> None:
        self._session, self._keys = session, keys

    def health(self) -> Health | None:
        return self._ask(self._keys.health, Health)

    def ledger(self) -> EffectsLedger | None:
        return self._ask(self._keys.effects, EffectsLedger)

    def model(self, revision: int | None = None) -> ModelSnapshot | None:
        """The model of a revision, or the latest; None, too, where the learner no longer has it."""
        return self._ask(self._keys.model + ("" if revision is None else f"?revision={revision}"), ModelSnapshot)

    def reports(self, after: int, at_a_time: int = 100) -> Iterator[IterationReport]:
        """The iterations that the learner still has, with a revision above `after`, in their order."""
        while True:
            history = self._ask(f"{self._keys.iteration}?after={after};limit={at_a_time}", IterationHistory)
            if history is None or not history.iterations:
                return
            yield from history.iterations
            after = history.iterations[-1].revision
            if after >= history.latest_revision:
                return

    def _ask(self, selector: str, form: type[FormType]) -> FormType | None:
        return answer(self._session, selector, form)


class Streams:
    """Rate, torque and channels from when this is made, in a bounded queue; beyond it the oldest messages go.

    The callbacks only put what came into the queue, in Zenoh's own thread: a viewer that hangs loses measurements for
    its plots, and slows nobody.
    """

    def __init__(self, session: zenoh.Session, keys: Keys, max_messages: int = 100_000) -> None:
        self._rate = keys.rate
        self._queue: deque[tuple[str, bytes, float]] = deque(maxlen=max_messages)
        self._declared: list[Any] = [
            session.declare_subscriber(key, Callback(self._put, indirect=False))
            for key in (keys.rate, keys.torque, keys.any_channel)
        ]

    def take(self) -> Iterator[tuple[str, Measurement, float]]:
        """What has come: the stream's name, its values, and when they came [s since 1970]."""
        for _ in range(len(self._queue)):
            key, payload, seen = self._queue.popleft()
            try:
                yield "yaw_rate" if key == self._rate else key.rpartition("/")[2], decode(Measurement, payload), seen
            except BadInput as error:
                # The learner refuses it too, counts it and says so in its health.
                log.debug("%s: %s", key, error)

    def close(self) -> None:
        for declared in self._declared:
            declared.undeclare()

    def _put(self, sample: zenoh.Sample) -> None:
        self._queue.append((str(sample.key_expr), sample.payload.to_bytes(), time.time()))
