"""Measurements from the bus: any bytes come in, only finite numbers go on, and every refusal is counted by its reason.

Each input key has a ring of its own that is emptied many times a second into a queue that is bounded by its bytes:
under overload the oldest messages go, the process does not grow, and queries are still answered. What the queue lost is
counted, and what the ring lost by the messages' numbers (`seq`).
"""

from __future__ import annotations

import math
from collections import defaultdict, deque
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol

import numpy as np
import zenoh
from zenoh.handlers import RingChannel

from incsvr.numerics import Array
from incsvr.signals import REQUIRED
from service.health.health_watch import HealthWatch
from service.inputs.forms.own import InvalidMeasurement, parse
from service.inputs.values import Values
from service.learner.node import LearnerNode
from service.recordings.archive import Archive
from service.wire import Keys

Listener = Callable[[Array, Array], bool]
"""Takes (n,) stamps [s] and values of a stream; True where a batch waits to be learned."""

Watcher = Callable[[Array, Array], None]
"""Takes (n,) stamps [s] and values of a stream, for health."""


class Subscriptions(Protocol):
    """Subscriptions of one learner, read from one thread alone."""

    def waiting(self) -> float:
        """The messages that wait to be read, as a part of those that may."""

    def read(self) -> Sequence[tuple[str, Values]]:
        """Streams' values that came since the last call, in the order in which the learner takes them."""

    def close(self) -> None:
        """Ends them."""


class Feed:
    """The subscriptions of one learner, emptied into it; `drain` empties them.

    Attributes:
        onward: by stream, who else in this process is told what of it may be learned from.
        watched: by stream, who else is told all of it, as health is.
        elsewhere: streams that are for others alone.
    """

    def __init__(self, node: LearnerNode, watch: HealthWatch, subscriptions: Sequence[Subscriptions]) -> None:
        self._node, self._watch, self._subscriptions = node, watch, subscriptions
        self.onward: defaultdict[str, list[Listener]] = defaultdict(list)
        self.watched: defaultdict[str, list[Watcher]] = defaultdict(list)
        self.elsewhere: set[str] = set()
        self._waiting: list[list[tuple[str, Values]]] = [[] for _ in subscriptions]

    def waiting(self) -> float:
        """The messages that wait to be read, as a part of those that may: 0 where there is nothing to do."""
        return max(subscriptions.waiting() for subscriptions in self._subscriptions)

    def drain(self) -> bool:
        """Takes what has come, from one thread alone; True where a batch waits to be learned."""
        batch_waits = self.hear()
        return self.learn() or batch_waits

    def hear(self) -> bool:
        """Reads what has come and tells it onward, before any of it is learned from: `learn` follows."""
        batch_waits = False
        for subscriptions, waiting in zip(self._subscriptions, self._waiting, strict=True):
            for name, each in subscriptions.read():
                if name not in self.elsewhere:
                    self._watch.add_values(name, each.t, each.value)
                for watcher in self.watched.get(name, ()):
                    watcher(each.t, each.value)
                learnable = each.to_learn()
                if learnable is None:
                    continue
                if name not in self.elsewhere:
                    waiting.append((name, learnable))
                for listener in self.onward.get(name, ()):
                    batch_waits |= listener(learnable.t, learnable.value)
        return batch_waits

    def learn(self) -> bool:
        """Passes on what was read to the learner; True where a batch waits."""
        batch_waits = False
        for waiting in self._waiting:
            for name, each in waiting:
                batch_waits |= self._node.push(name, each.t, each.value)
            waiting.clear()
        return batch_waits

    def close(self) -> None:
        for subscriptions in self._subscriptions:
            subscriptions.close()


RING_PLACES = 8192
"""Messages that a stream may be behind, 0.4 s at 20,000 a second; in time every place, 250 bytes, is resident."""
MIN_RING_PLACES = 512
"""Messages that a stream of one learner among many in a process may be behind, half a second at 1,000 a second: they
share the places, for a hundred learners would keep 400 MB else."""
MAX_PAYLOAD_BYTES = 1_000_000
"""The largest payload that is read; 50,000 numbers fit, and to read it takes a hundredth of a second."""
MAX_NAME_CHARS = 64
"""The longest name of a channel."""
QUEUE_BYTES = 8_000_000
"""Messages of a stream that wait to be read; the learners of a process share them, down to one large message."""
MESSAGE_OVERHEAD_BYTES = 500
"""The memory that a message takes beside its payload."""
TURN_BYTES = 1_000_000
"""The messages of one stream that are read before the next one's turn: a flood on one key keeps no other waiting."""
LARGE_MESSAGE_BYTES = 100_000
"""The size from which on a message is read for as long as others wait to be taken from their rings."""
AS_JSON = str(zenoh.Encoding.APPLICATION_JSON)
_ENCODINGS = {
    str(encoding)
    for encoding in (
        zenoh.Encoding.APPLICATION_JSON,
        zenoh.Encoding.TEXT_JSON,
        zenoh.Encoding.ZENOH_BYTES,
        zenoh.Encoding.ZENOH_STRING,
    )
}


def places(learners: int) -> int:
    """Messages that a stream of one of so many learners in a process may be behind."""
    return max(RING_PLACES // learners, MIN_RING_PLACES)


class _Queue:
    """The messages of one subscription on their way in; the name is None where it stands in the key."""

    def __init__(self, name: str | None, ring: Any, most_bytes: int) -> None:
        self.name, self.ring = name, ring
        self._most, self._bytes = most_bytes, 0
        self._waiting: deque[tuple[Any, Any, int]] = deque()

    def fill(self, most: int, refused: Callable[[str], None]) -> None:
        """Takes at most so many messages from the ring; for each that is not kept a reason is told."""
        receive, keep = self.ring.try_recv, self._waiting.append
        for _ in range(most):
            sample = receive()
            if sample is None:
                break
            payload = sample.payload
            size = len(payload) + MESSAGE_OVERHEAD_BYTES
            if size > MAX_PAYLOAD_BYTES + MESSAGE_OVERHEAD_BYTES:
                refused("too_large")
                continue
            keep((sample, payload, size))
            self._bytes += size
            while self._bytes > self._most:
                self._bytes -= self._waiting.popleft()[2]
                refused("queue_full")

    def part(self, places: int) -> float:
        """The messages that wait, as a part of a ring of so many places or of what one turn reads."""
        return max(len(self._waiting) / places, self._bytes / TURN_BYTES)

    def turn(self) -> Iterator[tuple[Any, Any, int]]:
        """The messages that are read before it is the next queue's turn: each with its payload and its size [bytes]."""
        read = 0
        while self._waiting and read < TURN_BYTES:
            message = self._waiting.popleft()
            size = message[2]
            self._bytes -= size
            read += size - MESSAGE_OVERHEAD_BYTES
            yield message


class Ingest:
    """The subscriptions of one learner of so many in the process to our own form.

    Without `required`, yaw rate and torque come from elsewhere.
    """

    def __init__(
        self,
        session: zenoh.Session,
        keys: Keys,
        watch: HealthWatch,
        learners: int = 1,
        required: bool = True,
        archive: Archive | None = None,
    ) -> None:
        self._watch, self._places, self._archive = watch, places(learners), archive
        most_bytes = max(QUEUE_BYTES // learners, MAX_PAYLOAD_BYTES + MESSAGE_OVERHEAD_BYTES)
        self._queues = [
            _Queue(name, session.declare_subscriber(key, RingChannel(self._places)), most_bytes)
            # The channels first: a sample is complete when both others have passed it, and takes what is there of them.
            for key, name in ((keys.any_channel, None), (keys.torque, "torque"), (keys.rate, "yaw_rate"))
            if required or name is None
        ]

    def waiting(self) -> float:
        """Takes what came from the rings, and says how full the fullest of them, or a turn of reading, would be."""
        self._fill()
        return max(queue.part(self._places) for queue in self._queues)

    def read(self) -> Sequence[tuple[str, Values]]:
        """The streams' values since the last call; all may be learned from."""
        read: list[tuple[str, Values]] = []
        for queue in self._queues:
            # Taken together, because the cost lies in the calls: a message alone costs twenty times as much.
            taken: dict[str, tuple[list[Any], list[Any]]] = {}
            self._fill()
            for sample, payload, size in queue.turn():
                self._take(sample, payload, queue.name, taken)
                if size > LARGE_MESSAGE_BYTES:
                    self._fill()  # to read it took long
            read += [(stream, Values.of(*_arrays(t, value))) for stream, (t, value) in taken.items() if t]
        return read

    def close(self) -> None:
        for queue in self._queues:
            queue.ring.undeclare()

    def _fill(self) -> None:
        for queue in self._queues:
            queue.fill(self._places, self._watch.add_refusal)

    def _take(self, sample: Any, payload: Any, name: str | None, taken: dict[str, tuple[list[Any], list[Any]]]) -> None:
        """Adds one message to those taken; whatever it holds, nothing is raised."""
        try:
            if sample.kind != zenoh.SampleKind.PUT:
                raise InvalidMeasurement("no_put")
            encoding = str(sample.encoding)
            if self._archive is not None:
                kept_as = AS_JSON if encoding in _ENCODINGS else encoding
                self._archive.came(str(sample.key_expr), kept_as, payload.to_bytes())
            if encoding not in _ENCODINGS:
                raise InvalidMeasurement("wrong_encoding")
            if name is None:
                name = str(sample.key_expr).rpartition("/")[2]
                if len(name) > MAX_NAME_CHARS or name in REQUIRED:
                    raise InvalidMeasurement("wrong_channel_name")
            t, value, sequence = parse(payload.to_bytes())
        except InvalidMeasurement as refusal:
            self._watch.add_refusal(str(refusal))
            return
        if sequence is not None:
            self._watch.add_number(name, sequence)
        stamps, values = taken.setdefault(name, ([], []))
        stamps += t
        values += value


def _arrays(t: list[Any], value: list[Any]) -> tuple[Array, Array]:
    try:
        return np.array(t, dtype=np.float64), np.array(value, dtype=np.float64)
    except OverflowError:  # an integer beyond all floats
        return _floats(t), _floats(value)


def _floats(items: list[Any]) -> Array:
    """Numbers as floats, NaN where an integer is beyond them."""
    return np.array([item if isinstance(item, float) or abs(item) < 10**300 else math.nan for item in items])
