"""One learner: measurements in, iterations out. No bus and no files, so that a hundred fit in one process.

A vehicle's axis is one `LearnerNode`. Measurements are pushed from any thread; one thread calls `learn` and gets the
next iteration whenever a batch is complete; anybody may ask `served` at any time. All that it publishes follows from
the measurements and their stamps alone, but the training time; with live tracing, also from the batch after which
`relearn` was called, and that depends on how long a trace took.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

from incsvr.checks import CurrentWarnings, Vehicle
from incsvr.checks.agreement import MODEL_KINDS
from incsvr.errors import BadInput
from incsvr.learning import checked_learner as guard
from incsvr.learning.checked_learner import Guarded
from incsvr.numerics import Array
from incsvr.numerics.plain import fields_to_plain
from incsvr.plant.axes import AXES
from incsvr.plant.mass_and_coriolis import inertia_in_force
from incsvr.plant.words import words_of
from incsvr.signals import REQUIRED
from incsvr.signals.samples import Samples
from service import wire
from service.config.configuration import Config
from service.config.traced_effects import TracedEffects
from service.learner.batches import MAX_WAITING_BATCHES, Batches
from service.learner.next_iteration import NextIteration, RateCoverage, learn_afresh, take_back, train
from service.learner.published import textbook_coefficients
from service.learner.raw_streams import RawStreams
from service.learner.stand_in import MEMORY_S as FORECAST_MEMORY_S
from service.learner.stand_in import StandIn
from service.learner.thrust import MAX_BEHIND_S, ThrustWatch
from service.learner.window import RecentBatches, Window
from service.state.memory import Memory, restore

RAW_MEMORY_S = max(2.0 * FORECAST_MEMORY_S, MAX_BEHIND_S)
"""The time before the end of a batch for which raw data are kept [s]: forecasts are tried on them once the batch is
learned, and the watch over the thrust may be behind."""


@dataclass(frozen=True, slots=True)
class BatchEnd:
    """The end of a batch.

    Attributes:
        time: its last stamp [s].
        served: what was served after it.
        paused_since: the first stamp of the batch that paused learning [s]; None where learning goes on.
    """

    time: float
    served: wire.ModelSnapshot
    paused_since: float | None


class LearnerNode:
    """The learner of one axis of one vehicle.

    Args:
        config: what is configured for it.
        boot: identifies this start of the process.
        memory: what an earlier `memory()` gave, to go on from there.
        published: the highest revision that was ever given, if that is known to be above the memory's.
        effects: traced effects that its samples are freed of, and that the published model carries.
    """

    def __init__(
        self,
        config: Config,
        boot: str,
        *,
        memory: Mapping[str, Any] | None = None,
        published: int = 0,
        effects: TracedEffects | None = None,
    ) -> None:
        self.config, self.boot = config, boot
        self.ledger = wire.EffectsLedger()
        findings: tuple[dict[str, Any], ...] = ()
        if effects is not None:
            findings = effects.findings
            self.ledger = wire.EffectsLedger(effects=findings, history=effects.history)
        self.ledger = replace(self.ledger, mode=config.tracing.live)
        self._settings = config.learner_settings()
        self._validation: dict[str, Samples] = {}
        known, self.remarks = restore(memory, self._settings)
        self._guarded = Guarded(known.learner, known.checks, known.before)
        self._covered = RateCoverage.of(known.covered)
        paused = known.checks.paused_since is not None
        self.current_warnings = CurrentWarnings("it was before the restart; the next batch decides" if paused else None)
        compensation = None if effects is None else effects.compensation
        signals = config.signal_settings()
        self.words = words_of(AXES[config.vehicle.axis])
        self._vehicle = Vehicle(
            signals.inertia,
            self._settings.rate_range,
            signals.smoothing,
            words=self.words,
        )
        window = Window(signals, config.tracing.window) if config.tracing.on else None
        coupled, others = config.coupled(), self._settings.others
        self.batches = Batches(signals, self._settings.batch, known.on_the_way, compensation, window, coupled, others)
        self.raw = RawStreams(signals)
        self.stand_in = StandIn(signals, self.raw, known.forecast, others, coupled, compensation, self.words)
        #: None where other velocities have a part in the torque, which its errors would hold.
        alone = coupled is None and not others
        self.thrust = ThrustWatch(signals, self.raw, known.thrust) if alone else None
        self._judged_until: float | None = None  # the last stamp of the last batch, learned or put aside [s]
        self._batch_ends: deque[BatchEnd] = deque(maxlen=MAX_WAITING_BATCHES)
        self.recent_batches = RecentBatches()
        self._published = max(published, known.revision)
        learned = known.learner
        self.served = wire.ModelSnapshot(
            boot=boot,
            revision=known.revision,
            iteration=learned.iterations,
            t=known.t,
            model=learned.model,
            inertia=config.vehicle.inertia,
            effects=findings,
        )

    def take_batch_ends(self) -> list[BatchEnd]:
        """The batches since the last time, learned or put aside, the oldest first; from the thread that learns."""
        ends = list(self._batch_ends)
        self._batch_ends.clear()
        return ends

    def validate_on(self, validation: Mapping[str, Samples]) -> None:
        """Sets the samples, by name, on which the served model's error is measured after each iteration."""
        self._validation = dict(validation)

    def push(self, stream: str, t: Array, value: Array) -> bool:
        """Takes (n,) stamps [s] and values of a stream, n ≥ 1; True where `learn` has something to do."""
        self.raw.push(stream, t, value)
        look_is_due = self.thrust is not None and stream in REQUIRED and self.thrust.is_due
        return self.batches.push(stream, t, value) or look_is_due

    def learn(self) -> NextIteration | None:
        """The next iteration, where a whole batch waits that is not put aside; call it from one thread alone.

        Where a batch pauses learning, that which takes the batch before back. Batches that hold too little motion for a
        first model are taken without one: there is nothing to publish yet. Where it raises, the batch is lost and all
        else is as it was.
        """
        self.stand_in.catch_up()
        due = -math.inf if self.thrust is None else self.thrust.due
        while (batch := self.batches.next_batch()) is not None:
            self._look(min(due, float(batch.time[-1])))
            self._judged_until = float(batch.time[-1])
            self.raw.forget(self._judged_until - RAW_MEMORY_S)
            guarded, verdict, taken_back = guard.judge(self._settings, self._vehicle, self._guarded, batch)
            outcome = None
            if verdict.learn:
                self.stand_in.batch_learned(self.served.model, batch, self.batches.smoothing)
                new = self._next(guarded, batch, self.served.effects, self._validation)
                if new.served.model.is_trained:
                    outcome = self._adopt(new)
                else:
                    self._keep(new)
            elif taken_back is not None:
                self.stand_in.taken_back()
                served = replace(self.served, revision=self._published + 1)
                axis, validation = AXES[self.config.vehicle.axis], self._validation
                outcome = self._adopt(take_back(guarded, batch, taken_back, served, self._covered, axis, validation))
            else:
                self._guarded = guarded
            self.current_warnings = self.current_warnings.after(verdict)
            if self.config.tracing.on:  # else nobody takes them, and each holds a model
                paused_since = self._guarded.checks.paused_since
                self._batch_ends.append(BatchEnd(self._judged_until, self.served, paused_since))
            if outcome is not None:
                return outcome
        self._look(due)
        return None

    def _look(self, until: float) -> None:
        """Looks for a change of the thrust, as often as is due until a time [s]."""
        if self.thrust is not None:
            checks = self._guarded.checks
            # A thrust that is lost may be what pauses learning; a sensor's fault would look like one.
            believed = checks.paused_since is None or checks.kinds <= MODEL_KINDS
            inertia = inertia_in_force(self.config.vehicle.inertia, self.served.effects)
            self.thrust.advance(until, inertia, believed)

    def relearn(
        self, effects: TracedEffects | None, validation: Mapping[str, Samples], since: float = -math.inf
    ) -> NextIteration | None:
        """Learns the recent data again, from nothing, with these effects in place of those in force.

        What came before the time `since` [s], when the vehicle may have been without them, is left out.

        The new learner is built beside the old one, which is served until one revision leads from the one to the other.
        Its batch is the one that was learned last, and its iteration counts on. Where the recent data teach nothing, as
        while a heading is held, what was learned before them stands, and what comes is freed of the effects. Where
        nothing was learned before them either, there is nothing to publish: the first model will hold the effects. Call
        it from the thread that learns.

        Raises:
            BadInput: the recent data fill no batch, or the learner refuses them. Whatever is raised, all is as it was.
        """
        compensation, restarts = None if effects is None else effects.compensation, self.batches.clock_restarts
        # What was put aside is learned, too: with these effects it may be as sound as it was before.
        until = self.served.t if self._judged_until is None else self._judged_until
        samples = self.batches.samples_under(compensation, -math.inf if until is None else until, since)
        size = self._settings.batch
        if len(samples) < size:
            lasts = size * self.config.signals.sample_period
            raise BadInput(f"the recent data fill no batch, which takes {lasts:g} s of data")
        guarded = learn_afresh(self._settings, self._vehicle, samples)
        guarded = replace(guarded, learner=replace(guarded.learner, iterations=self._guarded.learner.iterations))
        last, findings = samples.take(slice(len(samples) - size, None)), effects.findings if effects else ()
        new = self._next(guarded, last, findings, validation)
        if not new.served.model.is_trained and self.served.model.is_trained:
            new = self._next(self._guarded, last, findings, validation)
        self.batches.restart(compensation, float(last.time[-1]), restarts)
        self._validation = dict(validation)
        self.stand_in.change_effects(compensation)
        self.ledger = replace(self.ledger, batch=None)
        if not new.served.model.is_trained:
            self._keep(new)
            self.served = replace(self.served, effects=findings)
            return None
        return self._adopt(new)

    def update_ledger(
        self,
        found: tuple[dict[str, Any], ...],
        history: tuple[dict[str, Any], ...],
        work: Literal["trace", "prove"] | None,
    ) -> None:
        """Replaces the ledger: effects in force, other findings, steps, present work."""
        self.ledger = replace(self.ledger, effects=self.served.effects, found=found, history=history, work=work)

    @property
    def published(self) -> int:
        """The highest revision that was ever given."""
        return self._published

    def _next(
        self, guarded: Guarded, batch: Samples, effects: tuple[dict[str, Any], ...], validation: Mapping[str, Samples]
    ) -> NextIteration:
        """The iteration that leads from this state on, of a model that holds these effects; nothing changes yet."""
        covered = self._covered.over(batch, self._settings.rate_range, self.batches.clock_restarts)
        served = replace(self.served, revision=self._published + 1, effects=effects)
        axis = AXES[self.config.vehicle.axis]
        return train(self._settings, guarded, batch, served, covered, axis, validation)

    def _adopt(self, new: NextIteration) -> NextIteration:
        """Takes this as the learned state and the served model."""
        self._keep(new)
        self.served, self._published = new.served, new.served.revision
        if new.report.batch.parts:
            self.ledger = replace(self.ledger, batch=new.report.batch)
        return new

    def _keep(self, new: NextIteration) -> None:
        """Takes this as the learned state, without a change of the served model."""
        self._guarded, self._covered = new.guarded, new.covered
        if new.motion is not None:
            self.recent_batches.add(*new.motion, self.batches.smoothing, new.report.trained)

    @property
    def fresh_coverage(self) -> float:
        """The part of the configured rate range that fresh samples cover, 0 to 1."""
        return self._covered.fresh(self.served.t)

    def memory(self, whole: bool = False) -> dict[str, Any]:
        """The durable memory as plain data; `whole` adds the samples on their way to the next batch."""
        now = self._guarded
        known = Memory(
            now.learner,
            now.checks,
            now.before,
            revision=self.served.revision,
            covered=self._covered.times,
            t=self.served.t,
            thrust=None if self.thrust is None else self.thrust.to_dict(),
            on_the_way=self.batches.to_dict() if whole else None,
            forecast=self.stand_in.to_dict() if whole else None,
        )
        return fields_to_plain(known)

    def coefficients(self) -> wire.Coefficients:
        """The textbook's coefficients of what is served; none where nothing is learned."""
        return textbook_coefficients(self.served)

    def latest(self) -> wire.ModelSnapshot | None:
        """The snapshot of what is served; None before anything was learned."""
        return self.served if self.served.revision else None
