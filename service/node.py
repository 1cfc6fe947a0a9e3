"""One learner: measurements in, iterations out. No bus and no files, so that a hundred fit in one process.

A vehicle's axis is one `LearnerNode`. Measurements are pushed from any thread; one thread calls `learn` and gets the
next iteration whenever a batch is complete; anybody may ask `served` at any time. All that it publishes follows from
the measurements and their stamps alone, but the training time; with live tracing, also from the batch after which
`relearn` was called, and that depends on how long a trace took.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from incsvr import learner
from incsvr.errors import BadInput
from incsvr.learner import State
from incsvr.samples import Array, Samples
from service import wire
from service.batches import Batches
from service.config import Config
from service.effects import TracedEffects
from service.published import Served, report, snapshot
from service.window import Window


class NothingLearned(BadInput):
    """There is no model yet."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """One iteration as it is stored and published, and the learner's whole memory after it as plain data."""

    snapshot: wire.ModelSnapshot
    report: wire.IterationReport
    memory: dict[str, Any]


class LearnerNode:
    """The learner of one axis of one vehicle.

    Args:
        config: what is configured for it.
        boot: identifies this start of the process.
        memory: what an earlier `memory()` gave, to go on from there.
        validation: samples that the served model's error is measured on after each iteration, by name.
        effects: traced effects that its samples are freed of, and that the published model carries.
        clock: a monotonic clock [s]; only the training time is measured with it.
    """

    def __init__(
        self,
        config: Config,
        boot: str,
        *,
        memory: Mapping[str, Any] | None = None,
        validation: Mapping[str, Samples] | None = None,
        effects: TracedEffects | None = None,
        clock: Callable[[], float] = time.perf_counter,
    ) -> None:
        self.config, self.boot = config, boot
        self.ledger = wire.EffectsLedger()
        findings: tuple[dict[str, Any], ...] = ()
        if effects is not None:
            findings = effects.findings
            self.ledger = wire.EffectsLedger(effects=findings, history=effects.history)
        self._settings = config.learner_settings()
        self._validation = dict(validation or {})
        self._clock = clock
        self._state = learner.start(self._settings)
        self._covered = np.full(self._settings.bins, -math.inf)
        revision, newest, on_the_way = 0, None, None
        if memory is not None:
            self._state = State.from_dict(memory["learner"])
            self._covered = np.array([-math.inf if t is None else t for t in memory["covered"]])
            revision, newest = memory["revision"], memory["t"]
            on_the_way = memory.get("on_the_way")
        compensation = None if effects is None else effects.compensation
        signals = config.signal_settings()
        window = Window(signals, config.tracing.window) if config.tracing.live else None
        self.batches = Batches(signals, self._settings.batch, on_the_way, compensation, window)
        self._clock_restarts = 0
        self.served = Served(self._state.model, revision, self._state.iterations, newest, findings)

    def push(self, stream: str, t: Array, value: Array) -> bool:
        """Takes (n,) stamps [s] and values of a stream, n ≥ 1; True where a batch waits to be learned."""
        return self.batches.push(stream, t, value)

    def learn(self) -> Outcome | None:
        """The next iteration, where a whole batch waits; call it from one thread alone."""
        batch = self.batches.next_batch()
        return None if batch is None else self._iterate(batch, self.served.effects)

    def relearn(self, effects: TracedEffects | None, validation: Mapping[str, Samples]) -> Outcome | None:
        """Learns the recent data again, from nothing, with these effects in place of those in force.

        Until it returns, what was learned before is served; then one revision leads from the one to the other. Its
        batch is the one that was learned last, and its iteration counts on. Call it from the thread that learns.

        Returns:
            None where the recent data fill no batch: then nothing has changed.
        """
        compensation = None if effects is None else effects.compensation
        samples = self.batches.begin_anew(compensation, -math.inf if self.served.t is None else self.served.t)
        if samples is None:
            return None
        size, done = self._settings.batch, self._state.iterations
        state = learner.start(self._settings)
        for first in range(len(samples) % size, len(samples) - size, size):
            state, _ = learner.step(self._settings, state, samples.take(slice(first, first + size)))
        self._state, self._validation = replace(state, iterations=done), dict(validation)
        self.ledger = self.ledger.model_copy(update={"batch": None})
        return self._iterate(samples.take(slice(len(samples) - size, None)), effects.findings if effects else ())

    def tell(self, history: tuple[dict[str, Any], ...]) -> None:
        """What the ledger says from now on: the effects in force, and these steps."""
        self.ledger = self.ledger.model_copy(update={"effects": self.served.effects, "history": history})

    def _iterate(self, batch: Samples, effects: tuple[dict[str, Any], ...]) -> Outcome:
        """One iteration with this batch, of a model that holds these effects."""
        before, model = self.served, self._state.model
        predicted = model.predict(batch.yaw_rate).damping if model.is_trained else None
        began = self._clock()
        self._state, iteration = learner.step(self._settings, self._state, batch)
        if iteration.model.is_trained:
            iteration.model.predict(0.0)  # makes it ready for questions, here and not when the first one waits
        took = self._clock() - began
        self._cover(batch)
        self.served = Served(iteration.model, before.revision + 1, iteration.number, float(batch.time[-1]), effects)
        told = report(
            iteration,
            batch,
            self.served,
            boot=self.boot,
            predicted=predicted,
            training_s=took,
            validation=self._validation,
            learned=self.learned,
        )
        if told.batch.parts:
            self.ledger = self.ledger.model_copy(update={"batch": told.batch})
        return Outcome(self._snapshot(), told, self.memory())

    def predict(self, rates: Array) -> wire.DampingReply:
        """The damping at (n,) finite rates [rad/s].

        Raises:
            NothingLearned: ask again later.
        """
        served = self.served
        if not served.model.is_trained:
            raise NothingLearned("nothing has been learned yet; ask again once a first batch of samples is complete")
        prediction = served.model.predict(rates)
        return wire.DampingReply(
            rate=tuple(rates.tolist()),
            damping=tuple(prediction.damping.tolist()),
            sigma=tuple(prediction.sigma.tolist()),
            extrapolated=tuple(prediction.extrapolated.tolist()),
            iteration=served.iteration,
            revision=served.revision,
        )

    @property
    def learned(self) -> float:
        """The part of the configured rate range that fresh samples cover, 0 to 1."""
        newest = self.served.t
        if newest is None:
            return 0.0
        return float(np.mean(self._covered >= newest - self.config.health.fresh_for))

    def memory(self, whole: bool = False) -> dict[str, Any]:
        """All that must survive a restart, as plain data; `whole` adds the samples on their way to the next batch."""
        known: dict[str, Any] = {
            "learner": self._state.to_dict(),
            "revision": self.served.revision,
            "covered": [None if math.isinf(t) else t for t in self._covered.tolist()],
            "t": self.served.t,
        }
        if whole:
            known["on_the_way"] = self.batches.to_dict()
        return known

    def latest(self) -> wire.ModelSnapshot | None:
        """The snapshot of what is served; None before anything was learned."""
        return self._snapshot() if self.served.revision else None

    def _cover(self, batch: Samples) -> None:
        if self.batches.clock_restarts > self._clock_restarts:
            # The stamps begin at zero again: what was covered before counts as of then.
            self._clock_restarts = self.batches.clock_restarts
            self._covered[:] = np.where(np.isfinite(self._covered), 0.0, -math.inf)
        low, high = self._settings.rate_range
        bins = np.floor((batch.yaw_rate - low) / (high - low) * self._covered.size)
        inside = (bins >= 0) & (bins < self._covered.size)
        self._covered[bins[inside].astype(int)] = batch.time[inside]

    def _snapshot(self) -> wire.ModelSnapshot:
        return snapshot(self.served, self.boot, self.config.vehicle.inertia)
