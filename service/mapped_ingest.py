"""Measurements in the forms of others, as `inputs` says: keys of a vehicle's bus become the learner's streams.

All messages come into one queue, in the order in which they arrive, with the time of arrival: what is made of them does
not depend on when the queue is emptied. It is bounded, the oldest go first, and every loss is counted.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Mapping
from typing import Any

import numpy as np
import zenoh
from zenoh.handlers import Callback

from service.archive import Archive
from service.health import HealthWatch
from service.ingest import AS_JSON, MAX_PAYLOAD, MESSAGE_BYTES, QUEUE_BYTES, Ingest, places
from service.inputs.bus_keys import BRIDGED, bridged
from service.inputs.hearing import RATE, TORQUE, Hearing
from service.inputs.presets.ros import READ
from service.inputs.settings import Inputs, Source
from service.node import LearnerNode
from service.wire import Keys

SETTLED = 2.0
"""What has not come after so long [s] is said to be missing: a heartbeat comes every second, streams more often."""


class MappedIngest:
    """The subscriptions of one learner of so many in the process; `drain` empties them.

    Args:
        inputs: the mapping of the configuration.
        parameters: of the vehicle, as an earlier process heard them.

    Raises:
        BadInput: a topic or a form of the configuration is none.
    """

    def __init__(
        self,
        session: zenoh.Session,
        keys: Keys,
        node: LearnerNode,
        watch: HealthWatch,
        inputs: Inputs,
        parameters: Mapping[str, float],
        learners: int = 1,
        archive: Archive | None = None,
    ) -> None:
        self._session, self._node, self._watch, self._archive = session, node, watch, archive
        mapping = with_own_keys(inputs, keys)
        self.hearing = Hearing(mapping, parameters)
        self._began = time.monotonic()
        self._waiting: deque[tuple[str, Any, float, int]] = deque()
        self._bytes, self._most_bytes = 0, max(QUEUE_BYTES // learners, MAX_PAYLOAD + MESSAGE_BYTES)
        self._most, self._lock = places(learners), threading.Lock()
        self._first: dict[str, int] = {}
        self._announced: deque[str] = deque(maxlen=self._most)
        # Further channels still come on our own keys.
        self._channels = Ingest(session, keys, node, watch, learners, required=False, archive=archive)
        self._subscribers: list[Any] = []
        for expression in self.hearing.keys:
            self._subscribe(expression)
        if inputs.preset == "ros2":
            self._subscribers.append(
                session.liveliness().declare_subscriber(
                    BRIDGED, lambda sample: self._announced.append(str(sample.key_expr)), history=True
                )
            )

    def drain(self) -> bool:
        """Takes what has come, from one thread alone; True where a batch waits to be learned."""
        batch_waits = self._channels.drain()
        while self._announced:
            self._bridge(self._announced.popleft())
        taken: dict[str, tuple[list[float], list[float]]] = {}
        refused = self.hearing.refused
        while self._waiting:
            with self._lock:
                key, sample, arrival, size = self._waiting.popleft()
                self._bytes -= size
            payload = sample.payload.to_bytes()
            if self._archive is not None:
                self._archive.came(key, AS_JSON if payload[:1] == b"{" else str(sample.encoding), payload, arrival)
            for heard in self.hearing.hear(key, payload, arrival):
                if heard.sequence is not None:
                    self._watch.numbered(heard.name, heard.sequence)
                self._watch.received(heard.name, np.array(heard.t), np.array(heard.value))
                if self.hearing.may_learn:
                    t, value = taken.setdefault(heard.name, ([], []))
                    t += heard.t
                    value += heard.value
        while refused:
            self._watch.refused(*refused.popitem())
        # A sample is complete when both others have passed it, and takes what is there of the channels: they go first.
        for name in sorted(taken, key=lambda name: {TORQUE: 1, RATE: 2}.get(name, 0)):
            t, value = taken[name]
            batch_waits |= self._node.push(name, np.array(t), np.array(value))
        return batch_waits

    @property
    def why_not(self) -> str | None:
        """Why nothing that comes is learned from; None where it is."""
        early = self.hearing.armed is None and time.monotonic() - self._began < SETTLED
        return self.hearing.why_not if self.hearing.known and not early else None

    def notices(self) -> list[str]:
        """What a person should know of how the measurements come about, and what is missing."""
        missing = self.hearing.missing.values() if time.monotonic() - self._began > SETTLED else ()
        return [*missing, *self.hearing.notices()]

    def close(self) -> None:
        for subscriber in self._subscribers:
            subscriber.undeclare()
        self._channels.close()

    def _subscribe(self, expression: str) -> None:
        number = len(self._subscribers)

        def take(sample: Any) -> None:
            arrival, key = time.time(), str(sample.key_expr)
            if sample.kind != zenoh.SampleKind.PUT or self._first.setdefault(key, number) != number:
                return  # another subscription brings it as well
            size = len(sample.payload) + MESSAGE_BYTES
            if size > MAX_PAYLOAD + MESSAGE_BYTES:
                self._watch.refused("too_large")
                return
            lost = 0
            with self._lock:
                self._waiting.append((key, sample, arrival, size))
                self._bytes += size
                while self._bytes > self._most_bytes or len(self._waiting) > self._most:
                    self._bytes -= self._waiting.popleft()[3]
                    lost += 1
            if lost:
                self._watch.refused("queue_full", lost)

        # Called where the message is read: handlers with a thread of their own would change the order between keys.
        self._subscribers.append(self._session.declare_subscriber(expression, Callback(take, indirect=False)))

    def _bridge(self, token: str) -> None:
        """Listens to what a bridge of ROS 2 announces, where its type is read."""
        found = bridged(token)
        if found is None or found[0] in self.hearing.types or found[0] in self._first:
            return
        key, kind = found
        if kind in READ:
            self.hearing.announce(key, kind)
            self._subscribe(key)


def with_own_keys(inputs: Inputs, keys: Keys) -> Inputs:
    """The mapping in which what no preset brings, and nobody says, comes on the learner's own keys."""
    if inputs.preset not in ("incsvr", None):
        return inputs
    own = {}
    if inputs.yaw_rate is None:
        own["yaw_rate"] = Source(topic=keys.rate, field="value", form="incsvr")
    if inputs.torque is None and inputs.thrusters is None:
        own["torque"] = Source(topic=keys.torque, field="value", form="incsvr")
    return inputs.model_copy(update=own)
