"""Live tracing of one learner: looks at its residual, has a process beside it trace, and says what is in force.

Everything is called from the thread that learns, but `waits`. Nothing here waits for the process beside.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning.whiteness import p_value
from incsvr.samples import Array
from incsvr.verdict import Comparison, in_force, on_trial
from service.child import Child
from service.config import Config
from service.effects import TracedEffects, taken_up
from service.node import LearnerNode
from service.standing import RESIDUAL, Standing, Work
from service.wire import Batch

log = logging.getLogger(__name__)

INDEPENDENT = 5.0
"""Widths of the smoothing between two samples from which on their noise is nearly white."""
MOST_SAMPLES = 5000
"""Whose residual is looked at."""


class LiveTracing:
    """What is traced while a learner learns.

    Args:
        config: of the learner.
        kept: what an earlier `to_dict` gave, to go on from there.

    Raises:
        BadInput: the effects that were in force cannot be under this configuration.
    """

    def __init__(self, config: Config, kept: Mapping[str, Any] | None) -> None:
        self._config = config
        self.standing = Standing() if kept is None else Standing.from_dict(kept)
        self.effects: TracedEffects | None = None
        self._take_up(self.standing)
        every = math.ceil(INDEPENDENT * config.signals.smoothing / config.signals.sample_period - 1e-9)
        self._every = max(every, 1)
        self._known: Array = np.empty((3, 0))  # time, yaw rate and damping of the recent samples
        self._child: Child | None = None
        self._work: tuple[Work, float] = ("trace", 0.0)

    def to_dict(self) -> dict[str, Any]:
        """All that must survive a restart, as plain data."""
        return self.standing.to_dict()

    @property
    def waits(self) -> bool:
        """Whether the process beside has ended, and `conclude` is to be called. From any thread."""
        child = self._child
        return child is not None and child.ended

    def after(self, node: LearnerNode, batch: Batch) -> bool:
        """Looks at the residual after a batch, and begins what is due; True where the ledger says more than before."""
        self._keep(batch)
        newest = node.batches.covers()
        if self._child is not None or newest is None:
            return False
        self.standing = self.standing.clock_began_anew(newest)
        settings, before = self._config.tracing, self.standing
        p = self._white(node)
        work = before.due(newest, p, settings.window, settings.proof)
        if work is None:
            return False
        recent = {name: (t[t <= newest], value[t <= newest]) for name, (t, value) in node.batches.recent().items()}
        self._work = (work, newest)
        try:
            self._child = Child.start(self._job(work, newest), recent)
        except OSError as error:
            self._failed(before, f"no process could be started beside the learner: {error}")
            return True
        if self._child is None:
            return False
        if work == "trace":
            self._note(newest, "not white", f"p = {p:.1g}: tracing begins")
        return self.standing is not before

    def conclude(self) -> None:
        """Takes what the process beside has found, or why it has not."""
        child, (work, newest) = self._child, self._work
        if child is None:
            return
        self._child = None
        before = self.standing
        try:
            found = child.answer()
            if work == "trace":
                self._traced(newest, found)
            else:
                self._proven(newest, found)
        except BadInput as error:
            self._failed(before, str(error))
        except Exception as error:  # whatever it answered, learning goes on
            log.exception("%s: a fault of this program", self._config.prefix)
            self._failed(before, f"{type(error).__name__}: {error}")
        finally:
            child.close()

    def put_back(self, before: Standing, why: str) -> None:
        """What was in force before stays so, because the learner could not change over."""
        tried, newest = self.effects, self.standing.fresh
        self._take_up(before.after_proof(newest, "refused"))
        about = self.effects if tried is None else tried
        names = () if about is None else about.compensation.names
        verdict = "to be withdrawn" if tried is None else "proven"
        self._note(newest, "failed", f"{verdict}, but the learner could not change over: {why}", *names)

    def changed_over(self) -> None:
        """The learner has learned anew: its samples hold other effects than those before."""
        self._known = np.empty((3, 0))

    def close(self) -> None:
        """Ends the process beside."""
        if self._child is not None:
            self._child.close()
            self._child = None

    def _failed(self, before: Standing, why: str) -> None:
        """As before, but for what the same data would only fail at again: the next try is on fresh data."""
        work, newest = self._work
        trace = work == "trace"
        self._take_up(before.after_trace(newest, None) if trace else before.after_proof(newest, "waits"))
        self._note(newest, "failed", f"the {'trace' if trace else 'proof'} failed: {why}")

    def _keep(self, batch: Batch) -> None:
        time = np.array(batch.time)
        index = np.rint(time / self._config.signals.sample_period).astype(np.int64)
        new = np.stack([time, np.array(batch.rate), np.array(batch.damping)])[:, index % self._every == 0]
        if self._known.size and new.size and new[0, 0] <= self._known[0, -1]:
            self._known = np.empty((3, 0))
        known = np.concatenate([self._known, new], axis=1)[:, -MOST_SAMPLES:]
        self._known = known[:, known[0] >= time[-1] - self._config.tracing.window]

    def _white(self, node: LearnerNode) -> float:
        """The p-value of the residual that the served model leaves in the recent samples."""
        model = node.served.model
        if not model.is_trained or not self._known.size:
            return 1.0
        time, rate, damping = self._known
        # Damping vanishes at rest; a constant moment that was learned as damping is left in the residual.
        served = model.predict(rate).damping - model.predict(np.zeros(1)).damping
        return p_value(time, rate, damping - served, self._every * self._config.signals.sample_period)

    def _job(self, work: Work, newest: float) -> dict[str, Any]:
        if work == "trace":
            return {"work": work, "inertia": self._config.vehicle.inertia}
        standing = self.standing
        return {
            "work": work,
            "signals": asdict(self._config.signal_settings()),
            "learner": asdict(self._config.learner_settings()),
            "fresh": newest - self._config.tracing.proof,
            "without": None if standing.shadow is None else standing.force,
            "effects": standing.tried,
        }

    def _traced(self, newest: float, found: Mapping[str, Any]) -> None:
        effects = self._effects(found)
        if not effects.findings or effects.integrated:
            self.standing = self.standing.after_trace(newest, None)
        else:
            self.standing = self.standing.after_trace(newest, {name: found[name] for name in ("effects", "model")})
        if not found["effects"]:
            self._note(newest, "nothing found", "no effect of the catalogue explains it")
        for finding in found["effects"]:
            name = finding["effect"]
            if name not in effects.compensation.names:
                why = next(step["why"] for step in effects.history if step["effect"] == name)
                self._note(newest, "left out", why, name)
            elif effects.integrated:
                why = "nothing tells where the heading counts from: measure it, and add it to signals.channels"
                self._note(newest, "left out", why, name)
            else:
                self._note(newest, "shadow", finding["sentence"], name)

    def _proven(self, newest: float, found: Mapping[str, Any]) -> None:
        comparison = Comparison(**found)
        before = self.standing
        tried = before.tried
        if tried is None:
            return
        shadow = before.shadow is not None
        verdict = on_trial(comparison) if shadow else in_force(comparison, before.doubted)
        names = self._effects(tried).compensation.names
        instead = "in place of those in force, " if shadow and before.force is not None else ""
        self._take_up(before.after_proof(newest, verdict))
        if verdict in ("kept", "waits"):
            log.info("%s: %s: %s: %s", self._config.prefix, ", ".join(names), verdict, comparison.sentence)
        else:
            self._note(newest, verdict, instead + comparison.sentence, *names)

    def _take_up(self, standing: Standing) -> None:
        self.effects = None if standing.force is None else self._effects(standing.force)
        self.standing = standing

    def _effects(self, found: Mapping[str, Any]) -> TracedEffects:
        return taken_up(found, self._config.vehicle.inertia, self._config.signals.channels, "the live trace")

    def _note(self, t: float, step: str, why: str, *about: str) -> None:
        self.standing = self.standing.noted(t, step, why, about or (RESIDUAL,))
        log.info("%s: %s: %s: %s", self._config.prefix, ", ".join(about) or RESIDUAL, step, why)
