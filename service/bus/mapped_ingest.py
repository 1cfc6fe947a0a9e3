"""Measurements in the forms of others, as `inputs` says: keys of a vehicle's bus become the learner's streams.

What is made of the messages follows from them and from their times of arrival, and not from when they are taken.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from itertools import islice
from typing import Any

import zenoh
from zenoh.handlers import Callback

from incsvr.errors import BadInput
from service.bus.ingest import (
    AS_JSON,
    MAX_PAYLOAD_BYTES,
    MESSAGE_OVERHEAD_BYTES,
    QUEUE_BYTES,
    RING_PLACES,
    places,
)
from service.config.configuration import Config
from service.health.health_watch import HealthWatch
from service.inputs.bus_keys import BRIDGE_TOKENS, announced_type
from service.inputs.input_mapper import InputMapper
from service.inputs.live_clock import RATE
from service.inputs.mapper import TORQUE
from service.inputs.presets import ROS2
from service.inputs.settings import Axis, Inputs, Source
from service.inputs.values import Values
from service.recordings.archive import Archive
from service.wire import Keys


class Arrivals:
    """The subscriptions of what a mapping listens to, as one queue in the order of arrival; losses are counted.

    A handler with a thread of its own for each key, as Zenoh has them, would change the order between keys. `take`
    empties the queue, from one thread alone.

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

    def waiting(self) -> float:
        """What `take` would give, as a part of the messages that may wait."""
        return (len(self._waiting) + len(self._tokens)) / self._most

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
        if found is not None and found[1] in ROS2.listened and found[0] not in self._hearing.types:
            key, kind = found
            self._hearing.types[key] = kind
            self.subscribe(key)


GRACE_S = 2.0
"""The time after which what has not come is said to be missing [s]: a heartbeat comes every second, streams more
often."""
PLACES_FACTOR = 4
"""The messages that may wait over those of our own form: each is decoded by itself, at some 20,000 a second."""
TURN_MESSAGES = 1000
"""Messages that are mapped before others may look at the mapping."""


class MappedIngest:
    """The subscriptions of one learner of so many in the process to the forms of others.

    Args:
        config: whose `inputs` is the mapping.
        parameters: of vehicles, as an earlier process heard them.
        further: axes of other learners of the vehicle, whose efforts the thrusters make as well.

    Raises:
        BadInput: a topic or a form of the configuration is none.
    """

    def __init__(
        self,
        session: zenoh.Session,
        watch: HealthWatch,
        config: Config,
        parameters: Mapping[str, Any],
        learners: int = 1,
        archive: Archive | None = None,
        further: tuple[Axis, ...] = (),
    ) -> None:
        self._watch = watch
        self.mapper = InputMapper(mapping(config), parameters, further)
        self._began, self._lock = time.monotonic(), threading.Lock()
        most_bytes = PLACES_FACTOR * max(QUEUE_BYTES // learners, MAX_PAYLOAD_BYTES + MESSAGE_OVERHEAD_BYTES)
        waiting = PLACES_FACTOR * places(learners)
        self._arrivals = Arrivals(session, self.mapper, watch.add_refusal, waiting, most_bytes, archive)

    def waiting(self) -> float:
        """The messages that wait to be read, as a part of those that may."""
        return self._arrivals.waiting()

    def read(self) -> list[tuple[str, Values]]:
        """The streams' values since the last call; they may be learned from while the vehicle is armed."""
        came: list[tuple[str, Values]] = []
        arrivals = self._arrivals.take()
        while messages := list(islice(arrivals, TURN_MESSAGES)):
            with self._lock:
                found = self.mapper.take(messages)
            # A sample is complete when both others have passed it, and takes what there is of channels: they go first.
            came += sorted(found.items(), key=lambda each: {TORQUE: 1, RATE: 2}.get(each[0], 0))
        for each in self.mapper.numbers:
            self._watch.add_number(*each)
        self.mapper.numbers.clear()
        while self.mapper.refused:
            self._watch.add_refusal(*self.mapper.refused.popitem())
        return came

    @property
    def why_not(self) -> str | None:
        """The reason why measurements are not learned from; None if they are."""
        early = self.mapper.armed is None and time.monotonic() - self._began < GRACE_S
        return self.mapper.why_not if self.mapper.bindings and not early else None

    def notices(self) -> list[str]:
        """Notes for people on how the measurements are made, and what is missing."""
        late = time.monotonic() - self._began > GRACE_S
        with self._lock:
            return [*(self.mapper.missing.values() if late else ()), *self.mapper.notices()]

    def rate_key(self) -> str | None:
        """The key on which the yaw rate comes; None before it does."""
        with self._lock:
            return next(iter(self.mapper.keys_of(RATE)), None)

    def parameters(self) -> dict[str, dict[str, float]]:
        """The parameters that vehicles have sent, by vehicle."""
        with self._lock:
            return self.mapper.parameters_by_system

    def close(self) -> None:
        self._arrivals.close()


def mapping(config: Config) -> Inputs:
    """The inputs of a configuration: those that neither it nor its preset names have the learner's own keys.

    Raises:
        BadInput: a preset is to find another axis than yaw.
    """
    inputs, keys, axis = config.inputs, Keys(config.prefix), config.vehicle.axis
    if inputs.preset not in ("incsvr", None):
        if axis != "yaw" and (inputs.yaw_rate is None or (inputs.torque is None and inputs.thrusters is None)):
            raise BadInput(
                f"inputs.preset: {inputs.preset} proposes inputs for yaw alone; with vehicle.axis {axis} describe that "
                "velocity in inputs.yaw_rate, and its force in inputs.torque or inputs.thrusters"
            )
        return inputs
    own = {}
    if inputs.yaw_rate is None:
        own["yaw_rate"] = Source(topic=keys.rate, field="value", form="incsvr")
    if inputs.torque is None and inputs.thrusters is None:
        own["torque"] = Source(topic=keys.torque, field="value", form="incsvr")
    return inputs.model_copy(update=own)
