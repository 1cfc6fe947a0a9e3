"""What is played: the messages of streams in the order in which they are sent."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import zenoh
from numpy.typing import NDArray

from incsvr.numerics import Array
from service.wire import Keys, measurement


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


def messages(streams: Mapping[str, tuple[Array, Array]], whole_keys: bool = False) -> Messages:
    """The messages of streams, name or whole key → (stamps [s], values), each sent at its stamp."""
    number, t, value = (
        np.concatenate(columns)
        for columns in zip(*((np.full(t.size, k), t, v) for k, (t, v) in enumerate(streams.values())), strict=True)
    )
    order = np.argsort(t, kind="stable")
    return Messages(tuple(streams), number[order], t[order], t[order], value[order], whole_keys)
