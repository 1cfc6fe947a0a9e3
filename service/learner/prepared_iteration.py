"""One iteration, from its batch to what is said of it, as a value that nobody has adopted yet: nothing changes here."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from incsvr.checks import Vehicle
from incsvr.learning import checked_learner as guard
from incsvr.learning import learner
from incsvr.learning.checked_learner import Guarded
from incsvr.learning.excitation import Excitation
from incsvr.learning.learner import Iteration, Settings
from incsvr.numerics import Array
from incsvr.plant.axes import AXES
from incsvr.signals.samples import Samples
from service import wire
from service.config.configuration import Config
from service.learner.published import ServedModel, report, snapshot

FRESH_S = 900.0
"""How long a sample counts as fresh in `learned` [s], vehicle's time."""


@dataclass(frozen=True, slots=True)
class CommittedIteration:
    """One iteration as it is stored and published, and the learner's whole memory after it as plain data."""

    snapshot: wire.ModelSnapshot
    report: wire.IterationReport
    memory: dict[str, Any]


@dataclass(frozen=True, slots=True)
class RateCoverage:
    """The last time (bins,) [s] at which each bin of the rate range was covered, and the clocks' restarts by then."""

    at: Array
    clock_restarts: int = 0

    def over(self, batch: Samples, rate_range: tuple[float, float], clock_restarts: int) -> RateCoverage:
        """The coverage after this batch."""
        at = self.at.copy()
        if clock_restarts > self.clock_restarts:
            # The stamps begin at zero again: what was covered before counts as of then.
            at = np.where(np.isfinite(at), 0.0, -math.inf)
        low, high = rate_range
        bins = np.floor((batch.yaw_rate - low) / (high - low) * at.size)
        inside = (bins >= 0) & (bins < at.size)
        at[bins[inside].astype(int)] = batch.time[inside]
        return RateCoverage(at, clock_restarts)

    def fresh(self, newest: float | None) -> float:
        """The part of the range that was covered within FRESH_S before the newest sample, 0 to 1."""
        return 0.0 if newest is None else float(np.mean(self.at >= newest - FRESH_S))

    def to_list(self) -> list[float | None]:
        """The times as plain data, None where it never was."""
        return [None if math.isinf(t) else t for t in self.at.tolist()]


@dataclass(frozen=True, slots=True)
class TrainingStep:
    """The learner after a batch, and how it came there.

    Attributes:
        predicted: (n,) what was said of the batch before [N m]; None where nothing was.
        training_s: how long it took [s].
        motion: what moved the vehicle in a batch that was learned, and the batch.
    """

    guarded: Guarded
    batch: Samples
    iteration: Iteration
    predicted: Array | None
    training_s: float = 0.0
    motion: tuple[Excitation, Samples] | None = None


def train(settings: Settings, guarded: Guarded, batch: Samples) -> TrainingStep:
    """A batch is learned."""
    model = guarded.learner.model
    predicted = model.at(batch).damping if model.is_trained else None
    began = time.perf_counter()
    state, iteration = learner.step(settings, guarded.learner, batch)
    if iteration.model.is_trained:
        iteration.model.predict(0.0)  # makes it ready for questions, here and not when the first one waits
    took = time.perf_counter() - began
    after = Guarded(state, guarded.checks, guarded.learner)
    return TrainingStep(after, batch, iteration, predicted, took, (Excitation.of(batch, iteration.undriven), batch))


def take_back(guarded: Guarded, batch: Samples, iteration: Iteration) -> TrainingStep:
    """The batch before is taken back because of this one."""
    model = iteration.model
    return TrainingStep(guarded, batch, iteration, model.at(batch).damping if model.is_trained else None)


def learn_afresh(settings: Settings, vehicle: Vehicle, samples: Samples) -> Guarded:
    """The learner before the last batch of these samples, from nothing; what fills no batch is left out first."""
    guarded, size = guard.begin(settings), settings.batch
    for first in range(len(samples) % size, len(samples) - size, size):
        guarded, _, _ = guard.learn(settings, vehicle, guarded, samples.take(slice(first, first + size)))
    return guarded


@dataclass(frozen=True, slots=True)
class PreparedIteration:
    """One iteration that is done and not adopted yet."""

    guarded: Guarded
    served: ServedModel
    covered: RateCoverage
    snapshot: wire.ModelSnapshot
    report: wire.IterationReport
    motion: tuple[Excitation, Samples] | None


def prepare(
    step: TrainingStep,
    served: ServedModel,
    covered: RateCoverage,
    config: Config,
    boot: str,
    validation: Mapping[str, Samples],
) -> PreparedIteration:
    """The iteration that leads to what is to be served, as it is told."""
    told = report(
        step.iteration,
        step.batch,
        served,
        boot=boot,
        predicted=step.predicted,
        training_s=step.training_s,
        axis=AXES[config.vehicle.axis],
        validation=validation if step.iteration.model.is_trained else {},
        learned=covered.fresh(served.t),
    )
    shot = snapshot(served, boot, config.vehicle.inertia)
    return PreparedIteration(step.guarded, served, covered, shot, told, step.motion)
