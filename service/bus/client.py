"""A client of a learner: it opens the bus, and asks again until the learner answers or the time is over."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import zenoh

from incsvr.errors import BadInput, Failed
from service.bus.session import BusRefusal, client_config, client_place, nobody_at, open_session
from service.config.configuration import Config
from service.wire import ErrorReply, FormType, Keys, decode

RETRY_PERIOD_S = 0.3
"""Pause between two attempts while a learner restarts [s]; it is back within one and a half."""


class NoAnswer(Failed):
    """Nobody answered in time; the message is one sentence."""


@dataclass(frozen=True, slots=True)
class Client:
    """A session that reaches a learner's bus.

    Attributes:
        where: the bus, for people.
        until: of the monotonic clock [s]; afterwards no question is asked again.
        stop: ends all waiting.
    """

    session: zenoh.Session
    keys: Keys
    where: str
    until: float
    stop: threading.Event = field(default_factory=threading.Event)

    def ask(self, selector: str, form: type[FormType], payload: bytes | None = None) -> FormType:
        """The learner's answer; while it restarts, or has learned nothing, the question is asked again.

        Raises:
            NoAnswer: nobody answers within the time, or nothing has been learned until then.
            BadInput: the learner refuses the question.
        """
        return self.once(selector, form, lambda refusal: refusal.error_type != "BadInput", payload)

    def ask_if_any(self, selector: str, form: type[FormType]) -> FormType | None:
        """The learner's answer; None where it has nothing to answer with.

        Raises:
            NoAnswer: nobody answers within the time.
        """
        try:
            return self.once(selector, form, lambda refusal: refusal.error_type != "NothingLearned")
        except BadInput:
            return None

    def once(
        self,
        selector: str,
        form: type[FormType],
        again: Callable[[ErrorReply], bool],
        payload: bytes | None = None,
    ) -> FormType:
        """The answer; where it is a refusal, the question is asked again if `again` says so, else BadInput raised."""
        while True:
            problem = (
                f"a bus is at {self.where}, but no learner answers for {self.keys.prefix}; check the prefix (--prefix)"
            )
            for reply in self.session.get(selector, payload=payload, timeout=2.0):
                if reply.ok is not None:
                    return decode(form, reply.ok.payload.to_bytes())
                if reply.err is not None:
                    refusal = _refusal(reply.err.payload.to_bytes())
                    if not again(refusal):
                        raise BadInput(refusal.error)
                    problem = refusal.error
            if time.monotonic() >= self.until or self.stop.wait(RETRY_PERIOD_S):
                raise NoAnswer(problem)


@contextmanager
def bus_client(config: Config, patience_s: float, stop: threading.Event | None = None) -> Iterator[Client]:
    """A client of the configured bus.

    Args:
        patience_s: how long to wait for it and for an answer [s]; infinity waits until `stop`.
        stop: ends all waiting.

    Raises:
        NoAnswer: nobody listens there within the time.
        BusRefusal: somebody does, and we cannot meet.
    """
    where = client_place(config.bus)
    until = time.monotonic() + patience_s
    try:
        session = open_session(client_config(config.bus), patience_s, stop)
    except BusRefusal:
        raise
    except BadInput as error:
        raise NoAnswer(nobody_at(config.bus)) from error
    with session:
        yield Client(session, Keys(config.prefix), where, until, stop or threading.Event())


def _refusal(payload: bytes) -> ErrorReply:
    """The sentence of an error reply; Zenoh's own, on a timeout, is a bare text."""
    try:
        return decode(ErrorReply, payload)
    except BadInput:
        return ErrorReply(error=f"the bus refuses: {payload.decode(errors='replace')}", error_type="Bus")
