"""The learner's bus as the viewer hears it: everything in one bounded queue, and questions for what was missed.

The callbacks only put what came into the queue, in Zenoh's own thread: with a thread for each subscriber, as its Python
binding has it else, an iteration overtakes the model that was published before it. A viewer that hangs loses
measurements for its plots and nothing else; iterations that it missed are asked for again.
"""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import zenoh
from zenoh.handlers import Callback

from incsvr.errors import BadInput
from service.bus.session import answer
from service.wire import (
    EffectsLedger,
    Form,
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

MAX_QUEUE_MESSAGES = 100_000  # messages in the queue at most; beyond, the oldest go
ITERATIONS_A_QUESTION = 100  # iterations asked for at a time
ANSWER_TIMEOUT_S = 5.0
MAX_MODELS = 50  # models that came by themselves: nobody has to be asked for them


@dataclass(frozen=True, slots=True)
class Message:
    """What came in: a form, the stream's name where it is a measurement, and when [s since 1970]."""

    form: Form
    stream: str
    seen: float


@dataclass(frozen=True, slots=True)
class Presence:
    """The learner came or went."""

    here: bool


class Bus:
    """Everything that one learner says, from when this is made until `close`."""

    def __init__(self, session: zenoh.Session, keys: Keys) -> None:
        self._session, self._keys = session, keys
        self._forms: dict[str, type[Form]] = {
            keys.model: ModelSnapshot,
            keys.iteration: IterationReport,
            keys.health: Health,
            keys.effects: EffectsLedger,
            keys.rate: Measurement,
            keys.torque: Measurement,
            keys.any_channel: Measurement,
        }
        self._queue: deque[tuple[str, bytes, float] | Presence] = deque(maxlen=MAX_QUEUE_MESSAGES)
        self._filled = threading.Event()
        self._models: dict[tuple[str, int], ModelSnapshot] = {}
        self._declared: list[Any] = [
            session.declare_subscriber(key, Callback(self._put, indirect=False)) for key in self._forms
        ]
        self._declared.append(
            session.liveliness().declare_subscriber(keys.alive, Callback(self._presence, indirect=False), history=True)
        )

    def close(self) -> None:
        for declared in self._declared:
            declared.undeclare()

    def wake(self) -> None:
        """Ends a `wait`."""
        self._filled.set()

    def wait(self, seconds: float) -> Iterator[Message | Presence]:
        """What has come, at once where something has, else after at most this time [s]."""
        self._filled.wait(seconds)
        self._filled.clear()
        for _ in range(len(self._queue)):
            item = self._queue.popleft()
            if isinstance(item, Presence):
                yield item
            elif (message := self._decoded(*item)) is not None:
                if isinstance(message.form, ModelSnapshot):
                    self._keep(message.form)
                else:
                    yield message

    def reports(self, after: int) -> Iterator[IterationReport]:
        """The iterations that the learner still has, with a revision above `after`, in their order."""
        while True:
            history = self._ask(self._keys.iteration, f"after={after};limit={ITERATIONS_A_QUESTION}", IterationHistory)
            if history is None or not history.iterations:
                return
            yield from history.iterations
            after = history.iterations[-1].revision
            if after >= history.latest_revision:
                return

    def model(self, report: IterationReport) -> ModelSnapshot | None:
        """The model that an iteration made, as it came or as the learner still has it; None where neither is."""
        kept = self._models.get((report.boot, report.revision))
        return kept or self._ask(self._keys.model, f"revision={report.revision}", ModelSnapshot)

    def health(self) -> Health | None:
        return self._ask(self._keys.health, "", Health)

    def ledger(self) -> EffectsLedger | None:
        return self._ask(self._keys.effects, "", EffectsLedger)

    def _ask(self, key: str, parameters: str, form: type[FormType]) -> FormType | None:
        selector = f"{key}?{parameters}" if parameters else key
        try:
            return answer(self._session, selector, form, ANSWER_TIMEOUT_S)
        except BadInput as error:
            log.warning("%s: %s", selector, error)
            return None

    def _keep(self, snapshot: ModelSnapshot) -> None:
        """A model: it comes before the iteration that made it, which asks for it."""
        self._models[snapshot.boot, snapshot.revision] = snapshot
        if len(self._models) > MAX_MODELS:
            del self._models[next(iter(self._models))]

    def _put(self, sample: zenoh.Sample) -> None:
        self._queue.append((str(sample.key_expr), sample.payload.to_bytes(), time.time()))
        self._filled.set()

    def _presence(self, sample: zenoh.Sample) -> None:
        self._queue.append(Presence(sample.kind == zenoh.SampleKind.PUT))
        self._filled.set()

    def _decoded(self, key: str, payload: bytes, seen: float) -> Message | None:
        form: type[Any] = self._forms.get(key, Measurement)
        stream = "yaw_rate" if key == self._keys.rate else key.rpartition("/")[2]
        try:
            return Message(decode(form, payload), stream, seen)
        except BadInput as error:
            # The learner refuses it too, counts it and says so in its health.
            log.debug("%s: %s", key, error)
            return None
