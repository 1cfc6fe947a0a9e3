"""Measurements from the bus: any bytes come in, only finite numbers go on, and every refusal is counted by its reason.

Each input key has a ring of its own that is emptied many times a second: under overload the oldest messages go, the
process does not grow, and queries are still answered. What a ring lost is counted by the messages' numbers (`seq`).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import zenoh
from pydantic_core import from_json
from zenoh.handlers import RingChannel

from incsvr.samples import Array
from incsvr.signals import REQUIRED
from service.health import HealthWatch
from service.node import LearnerNode
from service.wire import Keys

#: Messages that a stream may be behind, 0.4 s at 20,000 a second; in time every place, 250 bytes, is resident.
RING = 8192
#: The learners of a process share them, down to half a second at 1,000 a second: a hundred would keep 400 MB else.
LEAST = 512
#: A larger payload is not read [bytes]; 200,000 numbers fit.
MAX_PAYLOAD = 4_000_000
MAX_NAME = 64
_ENCODINGS = {
    str(encoding)
    for encoding in (
        zenoh.Encoding.APPLICATION_JSON,
        zenoh.Encoding.TEXT_JSON,
        zenoh.Encoding.ZENOH_BYTES,
        zenoh.Encoding.ZENOH_STRING,
    )
}
_NUMBERS = {int, float}


def places(learners: int) -> int:
    """Messages that a stream of one of so many learners in a process may be behind."""
    return max(RING // learners, LEAST)


class Refused(Exception):
    """A message is no measurement; the one argument is the reason that is counted."""


def parse(payload: bytes) -> tuple[list[Any], list[Any], int | None]:
    """Stamps [s], values and number of a message; the lists have one length and hold numbers alone.

    Raises:
        Refused: the payload has not the contract's form. NaN and infinities pass: the synchroniser counts them.
    """
    try:
        data = from_json(payload)
    except ValueError:
        raise Refused("not_json") from None
    if type(data) is not dict or "t" not in data or "value" not in data:
        raise Refused("wrong_form")
    t, value, sequence = data["t"], data["value"], data.get("seq")
    if type(t) is not list and type(value) is not list:
        t, value = [t], [value]
    if type(t) is not list or type(value) is not list or not (sequence is None or type(sequence) is int):
        raise Refused("wrong_type")
    if len(t) != len(value):
        raise Refused("unequal_length")
    if not set(map(type, t)) | set(map(type, value)) <= _NUMBERS:
        raise Refused("wrong_type")
    return t, value, sequence


class Ingest:
    """The subscriptions of one learner, each with a ring of so many places; `drain` empties them."""

    def __init__(
        self, session: zenoh.Session, keys: Keys, node: LearnerNode, watch: HealthWatch, ring: int = RING
    ) -> None:
        self._node, self._watch, self._ring = node, watch, ring
        self._rings: list[tuple[str | None, Any]] = [
            (name, session.declare_subscriber(key, RingChannel(ring)))
            # The channels first: a sample is complete when both others have passed it, and takes what is there of them.
            for key, name in ((keys.any_channel, None), (keys.torque, "torque"), (keys.rate, "yaw_rate"))
        ]

    def drain(self) -> bool:
        """Takes what has come, from one thread alone; True where a batch waits to be learned."""
        batch_waits = False
        for name, ring in self._rings:
            # Taken together, because the cost lies in the calls: a message alone costs twenty times as much.
            taken: dict[str, tuple[list[Any], list[Any]]] = {}
            for _ in range(self._ring):
                sample = ring.try_recv()
                if sample is None:
                    break
                self._take(sample, name, taken)
            for stream, (t, value) in taken.items():
                batch_waits |= self._pass_on(stream, t, value)
        return batch_waits

    def close(self) -> None:
        for _, ring in self._rings:
            ring.undeclare()

    def _take(self, sample: Any, name: str | None, taken: dict[str, tuple[list[Any], list[Any]]]) -> None:
        """Adds one message to those taken; whatever it holds, nothing is raised."""
        try:
            if sample.kind != zenoh.SampleKind.PUT:
                raise Refused("no_put")
            if len(sample.payload) > MAX_PAYLOAD:
                raise Refused("too_large")
            if str(sample.encoding) not in _ENCODINGS:
                raise Refused("wrong_encoding")
            if name is None:
                name = str(sample.key_expr).rpartition("/")[2]
                if len(name) > MAX_NAME or name in REQUIRED:
                    raise Refused("wrong_channel_name")
            t, value, sequence = parse(sample.payload.to_bytes())
        except Refused as refusal:
            self._watch.refused(str(refusal))
            return
        if sequence is not None:
            self._watch.numbered(name, sequence)
        stamps, values = taken.setdefault(name, ([], []))
        stamps += t
        values += value

    def _pass_on(self, stream: str, t: list[Any], value: list[Any]) -> bool:
        try:
            stamps, values = np.array(t, dtype=np.float64), np.array(value, dtype=np.float64)
        except OverflowError:  # an integer beyond all floats
            stamps, values = _floats(t), _floats(value)
        if not stamps.size:
            return False
        self._watch.received(stream, stamps, values)
        return self._node.push(stream, stamps, values)


def _floats(items: list[Any]) -> Array:
    """Numbers as floats, NaN where an integer is beyond them."""
    return np.array([item if isinstance(item, float) or abs(item) < 10**300 else math.nan for item in items])
