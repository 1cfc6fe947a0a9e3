"""Queries to the learner, answered from what is served: bad ones get an error reply that says what is wrong.

The damping that is served has a thread of its own, so that no question for history, however long, delays it; so has
feed-forward, whose plan may have 20,000 steps. Every answer is short, so that whoever asks and does not read holds up
nobody: see `service.bus.session`.
"""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import zenoh
from zenoh.handlers import Callback, RingChannel

from incsvr.errors import BadInput
from service import wire
from service.bus.publishers import JSON
from service.config.traced_effects import OperatorVerb
from service.health.health_watch import HealthWatch
from service.learner import questions
from service.learner.feedforward_reply import feedforward_reply
from service.learner.node import LearnerNode
from service.learner.published import NothingLearned, check_trained, damping_reply, reply_to
from service.learner.questions import velocity_names
from service.learner.stand_in import forecast_reply
from service.state.history import History
from service.state.state_file import Row

log = logging.getLogger(__name__)

DAMPING_RING_PLACES = 256
"""Questions for damping that may wait; beyond, the oldest go unanswered and their askers time out."""
SLOW_RING_PLACES = 64
"""Questions for anything else that may wait."""
MAX_REPORTS = 200
"""Reports of an answer."""
MAX_REPORT_BYTES = 400_000
"""The size after which an answer with several reports ends; the next question goes on from there."""

Answer = Callable[[zenoh.Query], bytes]


class Answers:
    """The queryables of one learner."""

    def __init__(
        self, session: zenoh.Session, keys: wire.Keys, node: LearnerNode, watch: HealthWatch, history: History
    ) -> None:
        self._node, self._watch, self._history = node, watch, history
        #: What the velocities of a question for damping may be called.
        self._velocities = velocity_names(node.config)
        self._damping_key = keys.damping
        self._wake: Callable[[], None] = lambda: None
        self._from_history: deque[zenoh.Query] = deque(maxlen=SLOW_RING_PLACES)
        #: What an operator decides, each in a queryable of its own: access control sees a question's key alone.
        decisions: dict[OperatorVerb, str] = {"promote": keys.promote, "withdraw": keys.withdraw}
        self._queryables: list[Any] = []
        self._decisions = [(verb, key, self._declared(session, key)) for verb, key in decisions.items()]
        self._waiting_decisions: deque[tuple[OperatorVerb, str, zenoh.Query]] = deque(maxlen=SLOW_RING_PLACES)
        served = (
            (keys.damping, DAMPING_RING_PLACES, self._damping),
            (keys.feedforward, SLOW_RING_PLACES, self._feedforward),
        )
        self._threads: list[threading.Thread] = []
        for key, places, served_answer in served:
            ring: Any = session.declare_queryable(key, RingChannel(places), complete=True)
            self._queryables.append(ring)
            serve = partial(self._serve, ring.handler, key, served_answer)
            self._threads.append(threading.Thread(target=serve, name=key, daemon=True))
            self._threads[-1].start()
        answers: dict[str, Answer] = {
            keys.model: self._model,
            keys.iteration: self._iteration,
            keys.health: self._health,
            keys.effects: self._effects,
            keys.coefficients: self._coefficients,
            keys.forecast: self._forecast,
        }
        self._questions = [(key, self._declared(session, key), answer) for key, answer in answers.items()]

    def when_asked(self, wake: Callable[[], None]) -> None:
        """Sets what is called for each question that waits for `answer`."""
        self._wake = wake
        wake()  # one may have come before

    def _declared(self, session: zenoh.Session, key: str) -> deque[zenoh.Query]:
        """The questions for a key as they come, the last of them."""
        waiting: deque[zenoh.Query] = deque(maxlen=SLOW_RING_PLACES)

        def asked(query: zenoh.Query) -> None:
            waiting.append(query)
            self._wake()

        self._queryables.append(session.declare_queryable(key, Callback(asked, indirect=False), complete=True))
        return waiting

    def answer(self) -> bool:
        """Answers the waiting questions for anything but the served damping, from one thread alone.

        Returns:
            whether an operator waits for `decide`.
        """
        for verb, key, asked in self._decisions:
            while asked:
                self._waiting_decisions.append((verb, key, asked.popleft()))
        self._answer_all()
        return bool(self._waiting_decisions)

    def decide(self, decided: Callable[[OperatorVerb, str], bytes]) -> None:
        """Answers what operators have decided, from the thread that learns."""
        while self._waiting_decisions:
            verb, key, query = self._waiting_decisions.popleft()
            self._reply(query, key, partial(_decision, decided, verb))
            del query

    def _answer_all(self) -> None:
        # One of each in turn: whoever asks without a pause does not keep the others waiting.
        for _ in range(DAMPING_RING_PLACES):
            answered = False
            # A query is finished when it is dropped: no name is bound to it here, which would hold it until the next.
            for key, asked, answer in self._questions:
                if asked:
                    self._reply(asked.popleft(), key, answer)
                    answered = True
            if self._from_history:
                self._reply(self._from_history.popleft(), self._damping_key, self._damping)
                answered = True
            if not answered:
                return
        self._wake()  # more wait

    def close(self) -> None:
        for queryable in self._queryables:
            queryable.undeclare()
        for thread in self._threads:
            thread.join(timeout=1.0)

    def _serve(self, ring: Any, key: str, answer: Answer) -> None:
        """Answers questions for a key as they come, until it is undeclared."""
        while True:
            try:
                query = ring.recv()
            except zenoh.ZError:
                return  # undeclared
            given = query.parameters
            if key == self._damping_key and (given.get("at") is not None or given.get("revision") is not None):
                self._from_history.append(query)
                self._wake()
            else:
                self._reply(query, key, answer)
            del query

    def _reply(self, query: zenoh.Query, key: str, answer: Answer) -> None:
        self._watch.count_query()
        payload, refusal = b"", None
        try:
            payload = answer(query)
        except BadInput as error:
            refusal = wire.ErrorReply(error=str(error), error_type=type(error).__name__)  # what programs know it by
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
        if query.payload is None:
            answer = reply_to(self._node.served, str(query.parameters))
            if answer is not None:
                return answer
        asked = questions.parameters(query, *self._velocities, "at", "revision")
        velocities = questions.damping_query(query, asked, self._velocities, self._node.words)
        when = {name: text for name, text in asked.items() if name not in self._velocities}
        return wire.encode(damping_reply(self._served_at(when) if when else self._node.served, velocities))

    def _model(self, query: zenoh.Query) -> bytes:
        asked = questions.parameters(query, "at", "revision")
        if asked:
            return self._row_at(asked).snapshot
        latest = self._node.latest()
        if latest is None:
            raise NothingLearned("nothing has been learned yet; the first model follows the first batch")
        return wire.encode(latest)

    def _iteration(self, query: zenoh.Query) -> bytes:
        asked = questions.parameters(query, "after", "limit", "at", "revision")
        if "at" in asked or "revision" in asked:
            return self._row_at(asked).report
        latest = self._node.served.revision
        if "after" not in asked:
            if not latest:
                raise NothingLearned("no iteration has been done yet; the first follows the first batch")
            return self._history.revision(latest).report
        limit = questions.whole_number("limit", asked.get("limit", str(MAX_REPORTS)), MAX_REPORTS)
        reports = self._history.reports(questions.whole_number("after", asked["after"], 2**62), limit, MAX_REPORT_BYTES)
        return b'{"iterations":[' + b",".join(reports) + b'],"latest_revision":%d}' % latest

    def _health(self, query: zenoh.Query) -> bytes:
        questions.parameters(query)
        return wire.encode(self._watch.report(self._node))

    def _coefficients(self, query: zenoh.Query) -> bytes:
        questions.parameters(query)
        check_trained(self._node.served.model)
        return wire.encode(self._node.coefficients())

    def _effects(self, query: zenoh.Query) -> bytes:
        questions.parameters(query)
        return wire.encode(self._node.ledger)

    def _forecast(self, query: zenoh.Query) -> bytes:
        payload = questions.profile(query)
        asked = None if payload is None else wire.decode(wire.ForecastQuery, payload)
        return wire.encode(forecast_reply(self._node, asked))

    def _feedforward(self, query: zenoh.Query) -> bytes:
        payload = questions.profile(query)
        if payload is None:
            words = self._node.words
            raise BadInput(f'plan the {words.rate} in the payload, such as {{"t": [0, 5], "rate": [0, 0.1]}}')
        asked = wire.decode(wire.FeedforwardQuery, payload)
        return wire.encode(feedforward_reply(self._node, asked, self._velocities))

    def _served_at(self, asked: Mapping[str, str]) -> wire.ModelSnapshot:
        """The model that was served at a time, or published as a revision."""
        row = self._row_at(asked)
        snapshot = wire.decode(wire.ModelSnapshot, row.snapshot)
        if not snapshot.model.is_trained:
            raise NothingLearned(f"nothing had been learned with revision {row.revision}; ask for a later one")
        return snapshot

    def _row_at(self, asked: Mapping[str, str]) -> Row:
        """The row that was served at a time, or published as a revision."""
        further = asked.keys() - {"at", "revision"}
        if "at" in asked and "revision" in asked:
            raise BadInput("ask for a time (at=) or for a revision (revision=), not for both")
        if further:
            raise BadInput(f"ask for one revision or {' and '.join(sorted(further))}, not for both")
        if "at" in asked:
            return self._history.at(questions.number("at", asked["at"]))
        return self._history.revision(questions.whole_number("revision", asked["revision"], 2**62))


def _decision(decided: Callable[[OperatorVerb, str], bytes], verb: OperatorVerb, query: zenoh.Query) -> bytes:
    return decided(verb, questions.effect_name(query))
