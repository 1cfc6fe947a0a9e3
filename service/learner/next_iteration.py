"""One iteration, from its batch to what is said of it, as a value that nobody has adopted yet: nothing changes here."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from incsvr.checks import Vehicle
from incsvr.learning import checked_learner as guard
from incsvr.learning import learner
from incsvr.learning.checked_learner import Guarded
from incsvr.learning.excitation import Excitation
from incsvr.learning.learner import Iteration, Settings
from incsvr.learning.model import Model
from incsvr.numerics import Array
from incsvr.numerics.plain import or_none
from incsvr.plant.axes import Axis
from incsvr.signals.samples import Samples
from service import wire
from service.learner.published import report

FRESH_S = 900.0
"""How long a sample counts as fresh in `learned` [s], vehicle's time."""


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

    @staticmethod
    def of(times: tuple[float | None, ...]) -> RateCoverage:
        """The coverage that `times` gave."""
        return RateCoverage(np.array([-math.inf if t is None else t for t in times]))

    @property
    def times(self) -> tuple[float | None, ...]:
        """The times for the learner's memory, None where it never was."""
        return or_none(self.at)


@dataclass(frozen=True, slots=True)
class NextIteration:
    """One iteration that is done: all that the learner is after it, and how it is told."""

    guarded: Guarded  # the learned state, and what the checks remember
    covered: RateCoverage
    served: wire.ModelSnapshot
    report: wire.IterationReport
    # what moved the vehicle in a batch that was learned, and the batch
    motion: tuple[Excitation, Samples] | None = None


def train(
    settings: Settings,
    guarded: Guarded,
    batch: Samples,
    served: wire.ModelSnapshot,
    covered: RateCoverage,
    axis: Axis,
    validation: Mapping[str, Samples],
) -> NextIteration:
    """The iteration that a batch leads to.

    Args:
        served: with the revision and the effects of what is to be served.
        covered: with the batch.
        axis: in whose words it is told what was noticed.
        validation: samples, by name, that the error of what is to be served is measured on.
    """
    predicted = _said(guarded.learner.model, batch)
    began = time.perf_counter()
    state, iteration = learner.step(settings, guarded.learner, batch)
    if iteration.model.is_trained:
        iteration.model.predict(0.0)  # makes it ready for questions, here and not when the first one waits
    took = time.perf_counter() - began
    served = replace(served, model=iteration.model, iteration=iteration.number, t=float(batch.time[-1]))
    told = report(iteration, batch, served, predicted, axis, validation, covered.fresh(served.t), took)
    motion = Excitation.of(batch, iteration.undriven), batch
    return NextIteration(Guarded(state, guarded.checks, guarded.learner), covered, served, told, motion)


def take_back(
    guarded: Guarded,
    batch: Samples,
    iteration: Iteration,
    served: wire.ModelSnapshot,
    covered: RateCoverage,
    axis: Axis,
    validation: Mapping[str, Samples],
) -> NextIteration:
    """The iteration that takes the batch before back because of this one; otherwise as `train`."""
    served = replace(served, model=iteration.model, iteration=iteration.number)
    predicted = _said(iteration.model, batch)
    told = report(iteration, batch, served, predicted, axis, validation, covered.fresh(served.t))
    return NextIteration(guarded, covered, served, told)


def _said(model: Model, batch: Samples) -> Array | None:
    """The prediction of a batch (n,) [N m]; None where nothing is learned."""
    return model.at(batch).damping if model.is_trained else None


def learn_afresh(settings: Settings, vehicle: Vehicle, samples: Samples) -> Guarded:
    """The learner before the last batch of these samples, from nothing; what fills no batch is left out first."""
    guarded, size = guard.begin(settings), settings.batch
    for first in range(len(samples) % size, len(samples) - size, size):
        guarded, _, _ = guard.learn(settings, vehicle, guarded, samples.take(slice(first, first + size)))
    return guarded
