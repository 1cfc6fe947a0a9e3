"""Queries to the learner, answered from what is served: bad ones get an error reply that says what is wrong.

The damping has a thread of its own, so that no question for history, however long, delays one for damping.
"""

from __future__ import annotations

import logging
import math
import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import zenoh
from zenoh.handlers import RingChannel

from incsvr.errors import BadInput
from incsvr.samples import Array
from service import wire
from service.health import HealthWatch
from service.ingest import MAX_PAYLOAD
from service.node import LearnerNode, NothingLearned
from service.store import Store

log = logging.getLogger(__name__)

JSON = zenoh.Encoding.APPLICATION_JSON
#: Questions that may wait; beyond, the oldest go unanswered and their askers time out.
RING = 256
MAX_RATES = 100_000
MAX_REPORTS = 200


class Answers:
    """The queryables of one learner."""

    def __init__(
        self, session: zenoh.Session, keys: wire.Keys, node: LearnerNode, watch: HealthWatch, store: Store | None
    ) -> None:
        self._node, self._watch, self._store = node, watch, store
        self._damping_ring: Any = session.declare_queryable(keys.damping, RingChannel(RING), complete=True)
        self._damping_key = keys.damping
        self._thread = threading.Thread(target=self._serve_damping, name=keys.damping, daemon=True)
        self._thread.start()
        answers: dict[str, Callable[[zenoh.Query], bytes]] = {
            keys.model: self._model,
            keys.iteration: self._iteration,
            keys.health: lambda _: wire.encode(watch.report(node)),
            keys.effects: lambda _: wire.encode(node.ledger),
        }
        self._rings: list[tuple[str, Any, Callable[[zenoh.Query], bytes]]] = [
            (key, session.declare_queryable(key, RingChannel(RING), complete=True), answer)
            for key, answer in answers.items()
        ]

    def answer(self) -> None:
        """Answers the waiting questions for anything but damping, from one thread alone."""
        for key, ring, answer in self._rings:
            for _ in range(RING):  # whoever asks without a pause does not keep the others waiting
                query = ring.try_recv()
                if query is None:
                    break
                self._reply(query, key, answer)
                # A query is finished when it is dropped: leaving the name bound would hold it until the next one.
                del query

    def close(self) -> None:
        for _, ring, _ in self._rings:
            ring.undeclare()
        self._damping_ring.undeclare()
        self._thread.join(timeout=1.0)

    def _serve_damping(self) -> None:
        ring = self._damping_ring.handler
        while True:
            try:
                query = ring.recv()
            except zenoh.ZError:
                return  # undeclared
            self._reply(query, self._damping_key, self._damping)
            del query

    def _reply(self, query: zenoh.Query, key: str, answer: Callable[[zenoh.Query], bytes]) -> None:
        self._watch.queries += 1
        payload, refusal = b"", None
        try:
            payload = answer(query)
        except BadInput as error:
            refusal = wire.ErrorReply(error=str(error), error_type=_kind(error))
        except Exception as error:  # the next question must still be answered
            log.exception("a query to %s failed", key)
            refusal = wire.ErrorReply(error=str(error), error_type="Failed")
        try:
            if refusal is None:
                query.reply(key, payload, encoding=JSON)
            else:
                query.reply_err(wire.encode(refusal), encoding=JSON)
        except zenoh.ZError as error:
            log.warning("an answer to %s could not be sent: %s", key, error)

    def _damping(self, query: zenoh.Query) -> bytes:
        return wire.encode(self._node.predict(_rates(query)))

    def _model(self, query: zenoh.Query) -> bytes:
        at, revision = query.parameters.get("at"), query.parameters.get("revision")
        if at is None and revision is None:
            latest = self._node.latest()
            if latest is None:
                raise NothingLearned("nothing has been learned yet; the first model follows the first batch")
            return wire.encode(latest)
        if at is not None and revision is not None:
            raise BadInput("ask either at= a time or for a revision=, not for both")
        if self._store is None:
            raise BadInput("this learner keeps no history; configure a state directory")
        if at is not None:
            found = self._store.at(_number("at", at))
            missing = f"no model is kept from the vehicle's time {at} s or before"
        else:
            found = self._store.revision(_count("revision", revision, 2**62))
            missing = f"revision {revision} is not kept; the latest is {self._node.served.revision}"
        if found is None:
            raise NotKept(missing)
        return found

    def _iteration(self, query: zenoh.Query) -> bytes:
        if self._store is None:
            raise BadInput("this learner keeps no history; configure a state directory")
        after = query.parameters.get("after")
        if after is None:
            report = self._store.latest_report()
            if report is None:
                raise NothingLearned("no iteration has been done yet; the first follows the first batch")
            return report
        limit = _count("limit", query.parameters.get("limit", str(MAX_REPORTS)), MAX_REPORTS)
        reports = self._store.reports(_count("after", after, 2**62), limit)
        latest = self._node.served.revision
        return b'{"iterations":[' + b",".join(reports) + b'],"latest_revision":%d}' % latest


class NotKept(BadInput):
    """The history does not reach there."""


def _kind(error: BadInput) -> str:
    """What programs know an error by."""
    return type(error).__name__


def _rates(query: zenoh.Query) -> Array:
    """The asked yaw rates [rad/s], from the parameter `rate` or from the payload."""
    text = query.parameters.get("rate")
    if text is None:
        if query.payload is None:
            raise BadInput("name the yaw rates to answer for, such as ?rate=-0.2,0,0.2 in rad/s")
        if len(query.payload) > MAX_PAYLOAD:
            raise BadInput(f"the payload is longer than {MAX_PAYLOAD} bytes; ask in several queries")
        return np.array(wire.decode(wire.DampingQuery, query.payload.to_bytes()).rate)
    if text.count(",") >= MAX_RATES:
        raise BadInput(f"these are more than {MAX_RATES} rates; ask in several queries")
    try:
        rates = [float(part) for part in text.split(",")]
    except ValueError:
        raise BadInput(f"rate={text[:80]} is no list of numbers; write them like -0.2,0,0.2 in rad/s") from None
    if not all(map(math.isfinite, rates)):
        raise BadInput(f"rate={text[:80]} holds NaN or infinity; ask for finite rates in rad/s")
    return np.array(rates)


def _number(name: str, text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise BadInput(f"{name}={text[:80]} is no finite number")
    return number


def _count(name: str, text: str | None, most: int) -> int:
    try:
        number = int(text or "")
    except ValueError:
        number = -1
    if not 0 <= number <= most:
        raise BadInput(f"{name}={(text or '')[:80]} is no whole number from 0 to {most}")
    return number
