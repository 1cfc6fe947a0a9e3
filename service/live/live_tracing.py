"""Live tracing of one learner: has a process beside it trace, again and again, and says what is in force.

Everything is called from the thread that learns, but `waits`. Nothing here waits for the process beside.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping
from functools import partial
from typing import Any

from incsvr.compensation.promotion import Comparison
from incsvr.errors import BadInput
from service.config.configuration import Config
from service.learner.node import LearnerNode
from service.live import ledger, worker
from service.live.effects import OperatorVerb, TracedEffects, taken_up
from service.live.proof_decision import judged
from service.live.tracing_process import Died, TracingProcess
from service.live.tracing_state import RESIDUAL, Content, TracingState, Work
from service.live.worker import Begin, Worker
from service.live.worker_watch import WorkerWatch

log = logging.getLogger(__name__)


class LiveTracing:
    """What is traced while a learner learns.

    Args:
        config: of the learner.
        kept: what an earlier `to_dict` gave, to go on from there.
        begin: begins a piece of work beside the learner; None where one is at work already.

    Raises:
        BadInput: the effects that were in force cannot be under this configuration.
    """

    def __init__(self, config: Config, kept: Mapping[str, Any] | None, begin: Begin = TracingProcess.start) -> None:
        self._config, self._begin = config, begin
        self.standing = TracingState() if kept is None else TracingState.from_dict(kept)
        self.effects: TracedEffects | None = None
        self._take_up(self.standing)
        self._child: Worker | None = None
        self._work: tuple[Work, float] = ("trace", 0.0)
        self._watch = WorkerWatch()

    def to_dict(self) -> dict[str, Any]:
        """All that must survive a restart, as plain data."""
        return self.standing.to_dict()

    @property
    def waits(self) -> bool:
        """Whether the process beside has ended, and `conclude` is to be called. From any thread."""
        child = self._child
        return child is not None and child.ended

    @property
    def since(self) -> float:
        """From this time on the vehicle is known to be as the effects in force say [s]."""
        began = (self.standing.force or {}).get("since")
        return -math.inf if began is None else float(began)

    @property
    def notices(self) -> tuple[str, ...]:
        """What is wrong with the process beside, for health. From any thread."""
        return self._watch.notices()

    @property
    def work(self) -> Work | None:
        """What the process beside does now."""
        return None if self._child is None else self._work[0]

    def after(self, node: LearnerNode) -> bool:
        """Begins what is due, after a batch or a piece of work.

        Returns:
            whether the ledger says more than before.
        """
        newest = node.batches.window_end()
        if self._child is not None or newest is None:
            return False
        self.standing = self.standing.clock_began_anew(newest)
        settings, before = self._config.tracing, self.standing
        work = before.due(newest, settings.window, settings.proof)
        if work is None:
            return False
        recent = worker.recent(node.batches.recent(), settings, before, work, newest)
        self._work = (work, newest)
        try:
            self._child = self._begin(worker.job(self._config, before, work, newest), recent)
        except OSError as error:
            self._watch.died(work, f"no process could be started: {error}")
            self._failed(node, before, f"no process could be started beside the learner: {error}")
            return True
        if self._child is not None:
            self._watch.began(work)
        return self._child is not None

    def conclude(self, node: LearnerNode) -> TracingState | None:
        """Takes what the process beside has found, or why it has not.

        Returns:
            where the learner is to change over: what stands if it cannot.
        """
        child, (work, newest) = self._child, self._work
        if child is None:
            return None
        self._child = None
        before = self.standing
        try:
            found = child.answer()
            self._watch.answered()
            if work == "trace":
                self._traced(node, newest, found)
            else:
                self._proven(node, newest, found)
        except Died as error:
            self._watch.died(work, str(error))
            self._failed(node, before, str(error))
        except BadInput as error:
            self._watch.answered()
            self._failed(node, before, str(error))
        except Exception as error:  # whatever it answered, learning goes on
            log.exception("%s: a fault of this program", self._config.prefix)
            self._watch.died(work, f"{type(error).__name__}: {error}")
            self._failed(node, before, f"{type(error).__name__}: {error}")
        finally:
            child.close()
        return None if _same(self.standing.force, before.force) else before.after_proof(newest, "refused")

    def decide(self, node: LearnerNode, verb: OperatorVerb, name: str) -> TracingState | None:
        """An operator promotes what is found, or withdraws what is in force: all effects of one trace together.

        Returns:
            where the learner is to change over: what stands if it cannot; None where all is so already.

        Raises:
            BadInput: there is no such effect to promote or to withdraw; the sentence names those that are.
        """
        before, now = self.standing, () if self.effects is None else self.effects.compensation.names
        newest = node.served.t or 0.0
        offered = ledger.offered(self.standing, self._names)
        if verb == "promote":
            if name in offered:
                role, content = offered[name]
                names = self._names(content)
                self._take_up(before.promoted(role))
                why = f"by an operator; it was {role}{ledger.together(name, names)}"
                self._note(node.published + 1, newest, "promoted", why, *names, content=content)
                return before
            if name in now:
                return None
            raise BadInput(
                f"{name[:80]} was not found here; found: {', '.join(offered) or 'nothing'}; {ledger.in_force(now)}"
            )
        if name in now:
            self._take_up(before.withdrawn(now))
            why = f"by an operator{ledger.together(name, now)}; nobody else promotes it again"
            self._note(node.published + 1, newest, "withdrawn", why, *now, content=before.force)
            return before
        if name in before.held:
            return None
        raise BadInput(f"{name[:80]} is not in force here, so it cannot be withdrawn; {ledger.in_force(now)}")

    def put_back(self, node: LearnerNode, instead: TracingState, why: str) -> None:
        """What was in force before stays so, because the learner could not change over."""
        tried, newest = self.effects, node.served.t or self.standing.fresh
        self._take_up(instead)
        about = self.effects if tried is None else tried
        names = () if about is None else about.compensation.names
        verdict = "to be withdrawn" if tried is None else "to be promoted"
        told = f"{verdict}, but the learner could not change over: {why}"
        self._note(node.served.revision, newest, "failed", told, *names)

    def close(self) -> None:
        """Ends the process beside."""
        if self._child is not None:
            self._child.close()
            self._child = None

    def _failed(self, node: LearnerNode, before: TracingState, why: str) -> None:
        """As before, but for what the same data would only fail at again: the next try is on fresh data."""
        work, newest = self._work
        trace = work == "trace"
        told = f"the {'trace' if trace else 'proof'} failed: {why}"
        if not trace and before.shadow is not None and before.overdue(newest, self._config.tracing.window):
            names = self._names(before.shadow)
            self._take_up(before.after_proof(newest, "refused"))
            self._note(node.served.revision, newest, "refused", f"unproven within half a window; {told}", *names)
            return
        self._take_up(before.after_trace(newest, None) if trace else before.after_proof(newest, "waits"))
        if trace and ledger.last(before, [RESIDUAL]) == "failed":  # a vehicle that lies still fails each time
            log.info("%s: %s", self._config.prefix, told)
            return
        self._note(node.served.revision, newest, "failed", told)

    def _traced(self, node: LearnerNode, newest: float, found: Mapping[str, Any]) -> None:
        effects = self._effects(found)
        names = effects.compensation.names
        usable = bool(effects.findings) and not effects.integrated
        known = self.standing.proven is not None and set(self._names(self.standing.proven))
        content = {
            "effects": effects.findings,
            **{key: found[key] for key in ("model", "loop", "since")},
            "until": newest,
        }
        self.standing = self.standing.after_trace(newest, content if usable and known != set(names) else None)
        if usable and known == set(names):
            log.info("%s: %s: found again, and proven already", self._config.prefix, ", ".join(names))
            return
        note = partial(self._note, node.served.revision, newest)
        for finding in found["effects"]:
            name = finding["effect"]
            if ledger.last(self.standing, [name]) == "left out":
                continue
            if name not in names:
                note("left out", next(step["why"] for step in effects.history if step["effect"] == name), name)
            elif effects.integrated:
                why = "nothing tells where the heading counts from: measure it, and add it to signals.channels"
                note("left out", why, name)
            else:
                note("suspected", finding["sentence"], name, content=content)

    def _proven(self, node: LearnerNode, newest: float, found: Mapping[str, Any]) -> None:
        comparison, before = Comparison.from_dict(found), self.standing
        if before.tried is None:
            return
        content = before.tried[1]
        names = self._names(content)
        told = judged(before, before.tried, names, comparison, newest, self._config.tracing)
        self._take_up(before.after_proof(newest, told.verdict, told.compared, told.won))
        if told.step is None:
            log.info("%s: %s: %s: %s", self._config.prefix, ", ".join(names), told.verdict, told.why)
            return
        changes = not _same(self.standing.force, before.force)
        revision = node.published + 1 if changes else node.served.revision
        self._note(revision, newest, told.step, told.why, *names, content={**content, "proof": told.compared})

    def _take_up(self, standing: TracingState) -> None:
        self.effects = None if standing.force is None else self._effects(standing.force)
        self.standing = standing

    def _effects(self, found: Mapping[str, Any]) -> TracedEffects:
        return taken_up(found, self._config.vehicle.inertia, self._config.signals.channels, "the live trace")

    def _names(self, found: Mapping[str, Any]) -> tuple[str, ...]:
        return self._effects(found).compensation.names

    def _note(self, revision: int, t: float, step: str, why: str, *about: str, content: Content | None = None) -> None:
        """A step on data up to `t` [s], with the revision that is served after it, in the ledger and in the log."""
        told, known = {"step": step, "why": why, "t": t, "revision": revision}, ledger.evidence(content)
        for name in about or (RESIDUAL,):
            self.standing = self.standing.noted(told | known.get(name, {}), (name,))
        log.info("%s: %s: %s: %s", self._config.prefix, ", ".join(about) or RESIDUAL, step, why)


def _same(one: Content | None, other: Content | None) -> bool:
    """Whether both are the same trace, however often it was compared."""
    return (one or {}).get("model") is (other or {}).get("model")
