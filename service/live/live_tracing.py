"""Live tracing of one learner: has a process beside it trace, again and again, and says what is in force.

Everything is called from the thread that learns, but `waits`. Nothing here waits for the process beside.
"""

from __future__ import annotations

import logging
import math
from collections import deque
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

from incsvr.compensation.proof import Proof
from incsvr.errors import BadInput
from service.config.configuration import Config
from service.config.traced_effects import OperatorVerb, TracedEffects, effects_from_trace
from service.learner.batches import MAX_WAITING_BATCHES
from service.learner.node import BatchEnd, LearnerNode
from service.live import ledger
from service.live.tracing_process import Begin, TracingProcess, Worker, job, recent_streams
from service.live.tracing_state import RESIDUAL, TraceContent, TracingState, Work

log = logging.getLogger(__name__)


class LiveTracing:
    """The live tracing of a learner.

    Args:
        config: of the learner.
        memory: what an earlier `to_dict` gave, to go on from there.
        begin: begins a piece of work beside the learner; None where one is at work already.

    Raises:
        BadInput: the effects that were in force cannot be under this configuration.
    """

    def __init__(self, config: Config, memory: Mapping[str, Any] | None, begin: Begin = TracingProcess.start) -> None:
        self._config, self._begin = config, begin
        self.state = TracingState() if memory is None else self._readable(TracingState.from_dict(memory))
        self.effects: TracedEffects | None = None
        self._enter(self.state)
        self._child: Worker | None = None
        self._work: tuple[Work, BatchEnd] | None = None
        self._ends: deque[BatchEnd] = deque(maxlen=MAX_WAITING_BATCHES)

    def _readable(self, state: TracingState) -> TracingState:
        """The state without proven effects that an earlier version wrote in another form; it says so aloud."""
        try:
            if state.proven is not None:
                self._effects(state.proven)
        except BadInput as error:
            log.warning("%s: proven effects are set aside: %s", self._config.prefix, error)
            names = () if state.proven is None else state.proven.names
            return replace(state, proven=None).with_step({"step": "set aside", "why": str(error)}, names)
        return state

    def to_dict(self) -> dict[str, Any]:
        """The durable state as plain data."""
        return self.state.to_dict()

    @property
    def waits(self) -> bool:
        """Whether the process beside has ended, and `conclude` is to be called. From any thread."""
        child = self._child
        return child is not None and child.has_ended

    @property
    def since(self) -> float:
        """The time from which on the effects in force are known to apply [s]."""
        since = None if self.state.active is None else self.state.active.since
        return -math.inf if since is None else since

    @property
    def work(self) -> Work | None:
        """The present work of the tracing process."""
        return None if self._child is None or self._work is None else self._work[0]

    def after(self, node: LearnerNode) -> bool:
        """Begins what is due, after a batch or a piece of work.

        Work is due at the end of a batch, and sees the data until then. The ends of batches are looked at one after the
        other, also those that came while other work was being done: so the data decide it, and not the machine.

        Returns:
            whether the ledger says more than before.
        """
        self._ends.extend(node.take_batch_ends())
        if self._child is not None:
            return False
        while self._ends:
            end = self._ends[0]
            work = self._due(node, end)
            if work is not None:
                return self._start(node, work, end)
            self._ends.popleft()
        return False

    def _due(self, node: LearnerNode, end: BatchEnd) -> Work | None:
        """The work that is due with the data until the end of a batch."""
        if self._config.further_inputs and not end.served.model.is_trained:  # what they take is not known yet
            return None
        self.state = self.state.after_clock_restart(end.time)
        if node.batches.window_end(end.time) != end.time:  # its data are not there, or have gone
            return None
        settings, changed = self._config.tracing, self._changed(end)
        return self.state.due(end.time, settings.window, settings.proof, changed)

    def _changed(self, end: BatchEnd) -> float:
        """The time since which the vehicle is as it is now [s]: the batch that pauses learning holds both."""
        if end.paused_since is None:
            return -math.inf
        return end.paused_since + self._config.learner_settings().batch * self._config.signals.sample_period

    def _start(self, node: LearnerNode, work: Work, end: BatchEnd) -> bool:
        """Starts it beside the learner, where nothing else is at work; True where the ledger says more than before."""
        settings, before = self._config.tracing, self.state
        recent = recent_streams(node.batches.recent(end.time), settings, before, work, end.time, self._changed(end))
        self._work = (work, end)
        try:
            self._child = self._begin(job(self._config, before, work, end.time, end.served.model), recent)
        except OSError as error:
            self._conclude_failure(work, end, before, f"no process could be started beside the learner: {error}")
            return True
        return self._child is not None

    def conclude(self, node: LearnerNode) -> TracingState | None:
        """Takes what the process beside has found, or why it has not.

        Returns:
            where the learner is to change over: what stands if it cannot.
        """
        child, under_way = self._child, self._work
        if child is None or under_way is None:
            return None
        self._child = None
        before, (work, end) = self.state, under_way
        try:
            found = child.answer()
            if work == "trace":
                self._conclude_trace(end, found)
            else:
                self._conclude_proof(node, end, found)
        except BadInput as error:
            self._conclude_failure(work, end, before, str(error))
        except Exception as error:  # whatever it answered, learning goes on
            log.exception("%s: a fault of this program", self._config.prefix)
            self._conclude_failure(work, end, before, f"{type(error).__name__}: {error}")
        finally:
            child.close()
        return None if _same(self.state.active, before.active) else before.after_proof(end.time, "refused")

    def decide(self, node: LearnerNode, verb: OperatorVerb, name: str) -> TracingState | None:
        """An operator promotes what is found, or withdraws what is in force: all effects of one trace together.

        Returns:
            where the learner is to change over: what stands if it cannot; None where all is so already.

        Raises:
            BadInput: there is no such effect to promote or to withdraw; the sentence names those that are.
        """
        before, now = self.state, () if self.effects is None else self.effects.names
        newest = node.served.t or 0.0
        promotable = ledger.promotable(self.state, self._names)
        if verb == "promote":
            if name in promotable:
                role, content = promotable[name]
                names = self._names(content)
                self._enter(before.promote(role))
                why = f"by an operator; it was {role}{ledger.together(name, names)}"
                self._note(node.published + 1, newest, "promoted", why, *names, content=content)
                return before
            if name in now:
                return None
            raise BadInput(
                f"{name[:80]} was not found here; found: {', '.join(promotable) or 'nothing'}; {ledger.in_force(now)}"
            )
        if name in now:
            self._enter(before.withdraw(now))
            why = f"by an operator{ledger.together(name, now)}; nobody else promotes it again"
            self._note(node.published + 1, newest, "withdrawn", why, *now, content=before.active)
            return before
        if name in before.vetoed:
            return None
        raise BadInput(f"{name[:80]} is not in force here, so it cannot be withdrawn; {ledger.in_force(now)}")

    def put_back(self, node: LearnerNode, instead: TracingState, why: str) -> None:
        """Restores the effects in force before, because the learner could not switch."""
        tried, newest = self.effects, node.served.t or self.state.unseen_from
        self._enter(instead)
        about = self.effects if tried is None else tried
        names = () if about is None else about.names
        verdict = "to be withdrawn" if tried is None else "to be promoted"
        told = f"{verdict}, but the learner could not switch to it: {why}"
        self._note(node.served.revision, newest, "failed", told, *names)

    def close(self) -> None:
        """Ends the process beside."""
        if self._child is not None:
            self._child.close()
            self._child = None

    def _conclude_failure(self, work: Work, end: BatchEnd, before: TracingState, why: str) -> None:
        """The state after a failure: the next try is on fresh data, because the same data would fail again."""
        newest, revision = end.time, end.served.revision
        trace = work == "trace"
        told = f"the {'trace' if trace else 'proof'} failed: {why}"
        if not trace and before.suspect is not None and before.overdue(newest, self._config.tracing.window):
            names = self._names(before.suspect)
            self._enter(before.after_proof(newest, "refused"))
            self._note(revision, newest, "refused", f"unproven within half a window; {told}", *names)
            return
        self._enter(before.after_trace(newest, None) if trace else before.after_proof(newest, "waits"))
        if trace and ledger.last_step(before, [RESIDUAL]) == "failed":  # a vehicle that lies still fails each time
            log.info("%s: %s", self._config.prefix, told)
            return
        self._note(revision, newest, "failed", told)

    def _conclude_trace(self, end: BatchEnd, found: Mapping[str, Any]) -> None:
        if not found["effects"]:
            self.state = self.state.after_trace(end.time, None)
            return
        newest, effects = end.time, self._effects(TraceContent.from_dict(found))
        names = effects.names
        usable = bool(effects.findings)
        known = self.state.proven is not None and set(self._names(self.state.proven))
        content = TraceContent(effects.findings, found["model"], found["loop"], found["since"], newest)
        self.state = self.state.after_trace(newest, content if usable and known != set(names) else None)
        if usable and known == set(names):
            log.info("%s: %s: found again, and proven already", self._config.prefix, ", ".join(names))
            return
        note = partial(self._note, end.served.revision, newest)
        for finding in found["effects"]:
            name = finding["effect"]
            if ledger.last_step(self.state, [name]) == "left out":
                continue
            if name not in names:
                note("left out", next(step["why"] for step in effects.history if step["effect"] == name), name)
            else:
                note("suspected", finding["sentence"], name, content=content)

    def _conclude_proof(self, node: LearnerNode, end: BatchEnd, found: Mapping[str, Any]) -> None:
        proof, before, newest = Proof(**found), self.state, end.time
        if before.under_test is None:
            return
        content = before.under_test[1]
        names = self._names(content)
        decision = ledger.decide_proof(
            before, before.under_test, names, proof, newest, self._config.tracing, node.words
        )
        self._enter(before.after_proof(newest, decision.verdict, decision.error))
        if decision.step is None:
            log.info("%s: %s: %s: %s", self._config.prefix, ", ".join(names), decision.verdict, decision.why)
            return
        changes = not _same(self.state.active, before.active)
        revision = node.published + 1 if changes else end.served.revision
        compared = content if decision.error is None else content.compared(decision.error, newest)
        self._note(revision, newest, decision.step, decision.why, *names, content=compared)

    def _enter(self, state: TracingState) -> None:
        """Takes this as the state of live tracing, with these effects in force."""
        self.effects = None if state.active is None else self._effects(state.active)
        self.state = state

    def _effects(self, content: TraceContent) -> TracedEffects:
        vehicle, channels = self._config.vehicle, self._config.signals.channels
        return effects_from_trace(
            content.model, content.effects, vehicle.inertia, channels, "the live trace", "they are traced again"
        )

    def _names(self, content: TraceContent) -> tuple[str, ...]:
        return self._effects(content).names

    def _note(
        self, revision: int, t: float, step: str, why: str, *about: str, content: TraceContent | None = None
    ) -> None:
        """A step on data up to `t` [s], with the revision that is served after it, in the ledger and in the log."""
        told, known = {"step": step, "why": why, "t": t, "revision": revision}, ledger.evidence(content)
        for name in about or (RESIDUAL,):
            self.state = self.state.with_step(told | known.get(name, {}), (name,))
        log.info("%s: %s: %s: %s", self._config.prefix, ", ".join(about) or RESIDUAL, step, why)


def _same(one: TraceContent | None, other: TraceContent | None) -> bool:
    """Whether both are the same trace, however often it was compared."""
    return (None if one is None else one.model) is (None if other is None else other.model)
