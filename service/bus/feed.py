"""The way of measurements from the bus into a learner: read, told to health and onward, and only then learned from."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from incsvr.numerics import Array
from service.health.health_watch import HealthWatch
from service.learner.node import LearnerNode

Listener = Callable[[Array, Array], bool]
"""Takes (n,) stamps [s] and values of a stream; True where a batch waits to be learned."""

Watcher = Callable[[Array, Array], None]
"""Takes (n,) stamps [s] and values of a stream, for health."""


@dataclass(frozen=True, slots=True)
class Measurements:
    """Values of one stream: stamps (n,) [s] and values (n,), n ≥ 1."""

    name: str
    t: Array
    value: Array


@dataclass(frozen=True, slots=True)
class Arrived:
    """The messages that one reading of the bus gave.

    Attributes:
        measurements: all of it, as health is told.
        learnable: what of it may be learned from, in the order in which the learner takes it.
    """

    measurements: Sequence[Measurements]
    learnable: Sequence[Measurements]


class Subscriptions(Protocol):
    """Subscriptions of one learner, read from one thread alone."""

    def read(self) -> Arrived:
        """The messages since the last call."""

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
        self._waiting: list[list[Measurements]] = [[] for _ in subscriptions]

    def drain(self) -> bool:
        """Takes what has come, from one thread alone; True where a batch waits to be learned."""
        batch_waits = self.hear()
        return self.learn() or batch_waits

    def hear(self) -> bool:
        """Reads what has come and tells it onward, before any of it is learned from: `learn` follows."""
        batch_waits = False
        for subscriptions, waiting in zip(self._subscriptions, self._waiting, strict=True):
            arrived = subscriptions.read()
            for each in arrived.measurements:
                if each.name not in self.elsewhere:
                    self._watch.add_values(each.name, each.t, each.value)
                for watcher in self.watched.get(each.name, ()):
                    watcher(each.t, each.value)
            for each in arrived.learnable:
                if each.name not in self.elsewhere:
                    waiting.append(each)
                for listener in self.onward.get(each.name, ()):
                    batch_waits |= listener(each.t, each.value)
        return batch_waits

    def learn(self) -> bool:
        """Passes on what was read to the learner; True where a batch waits."""
        batch_waits = False
        for waiting in self._waiting:
            for each in waiting:
                batch_waits |= self._node.push(each.name, each.t, each.value)
            waiting.clear()
        return batch_waits

    def close(self) -> None:
        for subscriptions in self._subscriptions:
            subscriptions.close()
