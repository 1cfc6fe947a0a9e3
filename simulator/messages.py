"""What is played: the messages of streams in the order in which they are sent, with what goes wrong on the way."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import zenoh
from numpy.typing import NDArray

from incsvr.numerics import Array
from service.wire import Keys, measurement


class MessageSource(Protocol):
    """What is sent, in the order in which it is sent, as in `Messages`."""

    @property
    def names(self) -> tuple[str, ...]: ...
    @property
    def stream(self) -> NDArray[np.intp]: ...
    @property
    def send(self) -> Array: ...
    def __len__(self) -> int: ...
    def key(self, stream: int, keys: Keys) -> tuple[str, zenoh.Encoding]: ...
    def payload(self, index: int, sequence: int) -> bytes: ...
    def values(self, stream: int) -> int: ...


@dataclass(frozen=True, slots=True)
class Messages:
    """What is sent, in the order in which it is sent.

    Attributes:
        names: of the streams.
        stream: (n,) position in `names`.
        send: (n,) the vehicle's time at which a message is sent [s], not decreasing.
        t: (n,) the stamp in it [s].
        value: (n,) in the stream's unit.
        whole_keys: whether the names are whole keys, of whatever learner.
    """

    names: tuple[str, ...]
    stream: NDArray[np.intp]
    send: Array
    t: Array
    value: Array
    whole_keys: bool = False

    def __len__(self) -> int:
        return self.t.size

    def key(self, stream: int, keys: Keys) -> tuple[str, zenoh.Encoding]:
        """Where a stream is sent, and as what."""
        name = self.names[stream]
        return name if self.whole_keys else keys.stream(name), zenoh.Encoding.APPLICATION_JSON

    def payload(self, index: int, sequence: int) -> bytes:
        """What is sent, as the message of its stream with that number."""
        return measurement(float(self.t[index]), float(self.value[index]), sequence)

    def values(self, stream: int) -> int:
        """How many values a stream has: one in each of its messages."""
        return int(np.count_nonzero(self.stream == stream))


@dataclass(frozen=True, slots=True)
class Faults:
    """What goes wrong between a sensor and the bus.

    Attributes:
        drop_outs: of each stream in a minute.
        drop_out_length: their mean length [s].
        jitter: a message comes late by up to this [s], and so out of order.
        duplicates: share of the messages that are sent twice.
    """

    drop_outs: float = 0.0
    drop_out_length: float = 1.0
    jitter: float = 0.0
    duplicates: float = 0.0


def messages(streams: Mapping[str, tuple[Array, Array]], faults: Faults = Faults(), seed: int = 0) -> Messages:
    """The messages of streams, name → (stamps [s], values), with the faults that the seed draws."""
    rng = np.random.default_rng(seed)
    parts = []
    for number, (t, value) in enumerate(streams.values()):
        kept = ~_dropped(t, faults, rng)
        index = np.flatnonzero(kept)
        index = np.concatenate((index, index[rng.random(index.size) < faults.duplicates]))
        send = t[index] + rng.uniform(0.0, faults.jitter, index.size) if faults.jitter else t[index]
        parts.append((np.full(index.size, number), send, t[index], value[index]))
    stream, send, t, value = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    order = np.argsort(send, kind="stable")
    return Messages(tuple(streams), stream[order], send[order], t[order], value[order])


def _dropped(t: Array, faults: Faults, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Which of the stamps fall into a drop-out."""
    lost = np.zeros(t.size, dtype=bool)
    if not t.size:
        return lost
    for start in rng.uniform(t[0], t[-1], rng.poisson(faults.drop_outs * (t[-1] - t[0]) / 60.0)):
        lost |= (t >= start) & (t < start + rng.exponential(faults.drop_out_length))
    return lost
