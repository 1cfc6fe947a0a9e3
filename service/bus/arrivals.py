"""A bounded queue of the messages on some keys, in the order of arrival and with its time; losses are counted.

A handler with a thread of its own for each key, as Zenoh has them, would change the order between keys.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from typing import Any

import zenoh
from zenoh.handlers import Callback

from service.bus.ingest import AS_JSON, MAX_PAYLOAD_BYTES, MESSAGE_OVERHEAD_BYTES, QUEUE_BYTES, RING_PLACES
from service.inputs.bus_keys import BRIDGE_TOKENS, announced_type
from service.inputs.input_mapper import InputMapper
from service.inputs.presets.ros import LISTENED_TYPES
from service.recordings.archive import Archive


class Arrivals:
    """The subscriptions of what a mapping listens to; `take` empties the queue, from one thread alone.

    Args:
        refused: told the reason and the count of messages that are not kept.
        places: messages that may wait.
        most_bytes: that they may hold.
        archive: keeps what came.
    """

    def __init__(
        self,
        session: zenoh.Session,
        hearing: InputMapper,
        refused: Callable[[str, int], None],
        places: int = RING_PLACES,
        most_bytes: int = QUEUE_BYTES,
        archive: Archive | None = None,
    ) -> None:
        self._archive = archive
        self._session, self._hearing, self._refused = session, hearing, refused
        self._waiting: deque[tuple[str, Any, float, int]] = deque()
        self._bytes, self._most, self._most_bytes = 0, places, most_bytes
        self._lock = threading.Lock()
        self._first: dict[str, int] = {}
        self._tokens: deque[str] = deque(maxlen=places)
        self._subscribers: list[Any] = []
        for expression in hearing.keys:
            self.subscribe(expression)
        if hearing.inputs.preset == "ros2":
            bridges = session.liveliness().declare_subscriber(
                BRIDGE_TOKENS, lambda sample: self._tokens.append(str(sample.key_expr)), history=True
            )
            self._subscribers.append(bridges)

    def take(self) -> Iterator[tuple[str, bytes, float]]:
        """Key, payload and time of arrival [s since 1970] of what came until now."""
        while self._tokens:
            self._listen(self._tokens.popleft())
        for _ in range(len(self._waiting)):
            with self._lock:
                if not self._waiting:
                    return
                key, sample, arrival, size = self._waiting.popleft()
                self._bytes -= size
            payload = sample.payload.to_bytes()
            if self._archive is not None:
                self._archive.came(key, AS_JSON if payload[:1] == b"{" else str(sample.encoding), payload, arrival)
            yield key, payload, arrival

    def close(self) -> None:
        for subscriber in self._subscribers:
            subscriber.undeclare()

    def subscribe(self, expression: str) -> None:
        """Listens to a key expression as well; what another one brings is not taken twice."""
        number = len(self._subscribers)

        def arrived(sample: Any) -> None:
            at, key = time.time(), str(sample.key_expr)
            if sample.kind == zenoh.SampleKind.PUT and self._first.setdefault(key, number) == number:
                self._keep(key, sample, at)

        self._subscribers.append(self._session.declare_subscriber(expression, Callback(arrived, indirect=False)))

    def _keep(self, key: str, sample: Any, at: float) -> None:
        size, lost = len(sample.payload) + MESSAGE_OVERHEAD_BYTES, 0
        if size > MAX_PAYLOAD_BYTES + MESSAGE_OVERHEAD_BYTES:
            self._refused("too_large", 1)
            return
        with self._lock:
            self._waiting.append((key, sample, at, size))
            self._bytes += size
            while self._bytes > self._most_bytes or len(self._waiting) > self._most:
                self._bytes -= self._waiting.popleft()[3]
                lost += 1
        if lost:
            self._refused("queue_full", lost)

    def _listen(self, token: str) -> None:
        """Listens to what a bridge of ROS 2 announces, where its type is read."""
        found = announced_type(token)
        if found is not None and found[1] in LISTENED_TYPES and found[0] not in self._hearing.types:
            key, kind = found
            self._hearing.announce(key, kind)
            self.subscribe(key)
