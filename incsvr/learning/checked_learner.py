"""The learner behind the checks: a batch is judged before it is learned, and a suspected one is undone.

    guarded, outcome = learn(settings, vehicle, guarded, batch)

The fault that pauses learning may have begun within the batch before. That one is taken back, so that what is served
was learned from batches after which another was sound.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from incsvr.checks import MODEL_KINDS, Curve, Finding, ServedCurve, Vehicle, Verdict, check, verdict_sentences
from incsvr.checks import State as Checks
from incsvr.learning.freeing import as_one_curve
from incsvr.learning.learner import Iteration, Settings, State, start, step
from incsvr.learning.model import Model
from incsvr.numerics import Array
from incsvr.signals.samples import Samples


@dataclass(frozen=True, slots=True)
class Guarded:
    """The learned state, the memory of the checks, and the state before the last batch."""

    learner: State  # what is learned
    checks: Checks  # what the checks remember
    before: State | None = None  # the learner before the last batch; None where there is nothing to go back to


def begin(settings: Settings) -> Guarded:
    """Before the first batch."""
    return Guarded(start(settings), Checks())


def judge(
    settings: Settings, vehicle: Vehicle, guarded: Guarded, batch: Samples
) -> tuple[Guarded, Verdict, Iteration | None]:
    """The verdict of the checks on a batch; if it pauses learning, an iteration withdraws the batch before."""
    learner, before = guarded.learner, guarded.before
    older = None if before is None else curve(before.model)
    # The checks know one curve.
    alone = as_one_curve(learner.model, batch) if learner.model.several is not None else batch
    checks, verdict = check(guarded.checks, vehicle, alone, curve(learner.model), older)
    if not verdict.suspect or before is None:
        return Guarded(learner, checks, before), verdict, None
    number = learner.iterations + 1
    return Guarded(replace(before, iterations=number), checks), verdict, _taken_back(number, before, batch, verdict)


def learn(
    settings: Settings, vehicle: Vehicle, guarded: Guarded, batch: Samples
) -> tuple[Guarded, Verdict, Iteration | None]:
    """Judges a batch, and learns it where it is sound; an iteration also where the batch before is taken back."""
    guarded, verdict, taken_back = judge(settings, vehicle, guarded, batch)
    if not verdict.learn:
        return guarded, verdict, taken_back
    learner, iteration = step(settings, guarded.learner, batch)
    return Guarded(learner, guarded.checks, guarded.learner), verdict, iteration


def follow(
    settings: Settings, vehicle: Vehicle, samples: Samples, rest: bool = False
) -> Iterator[tuple[Verdict, Iteration | None]]:
    """The verdict on each full batch of whole recordings, and its iteration if it is learned.

    Args:
        rest: what is left over at the end is a batch as well.
    """
    guarded = begin(settings)
    for first in range(0, len(samples) if rest else len(samples) - settings.batch + 1, settings.batch):
        batch = samples.take(slice(first, first + settings.batch))
        guarded, verdict, iteration = learn(settings, vehicle, guarded, batch)
        yield verdict, iteration


def _taken_back(number: int, before: State, batch: Samples, verdict: Verdict) -> Iteration:
    """The iteration that leads back to what was learned before the last batch."""
    model = before.model
    stamps = np.full(model.support_rate.size, batch.time[0])
    support = Samples(stamps, model.support_rate, model.support_damping, model.others_at_support)
    return replace(
        Iteration(number, False, model, support, support),
        time_span=verdict.span,
        change=f"the batch before is withdrawn: {verdict.findings[0].sentence}",
    )


def curve(model: Model) -> Callable[[Array], Curve] | None:
    """The curve of a model for the checks; None before anything is learned."""
    known = model.trained_range
    if known is None or not known[0] < known[1]:
        return None
    # where the water moves the vehicle, a sample scatters by that as well
    sigma = float(np.hypot(model.sigma, np.sqrt(model.water.moment)))
    return lambda rate: Curve.of(partial(_served, model), rate, known, sigma)


def _served(model: Model, rate: Array) -> ServedCurve:
    said = model.predict(rate)
    return ServedCurve(said.damping, said.doubt, ~said.extrapolated)


@dataclass(frozen=True, slots=True)
class Sensors:
    """The verdict on the sensors of one recording."""

    remarks: tuple[str, ...]  # a sentence for each thing that a sensor or a clock does wrong
    # a sentence for each thing by which the motion differs from what was learned until then; it may be the vehicle's,
    # a sensor's, or what a tracer looks for
    of_the_model: tuple[str, ...]
    refusal: Finding | None  # after which nothing is to be concluded from the recording; None where something is
    heading_reversed: bool  # the heading counts in the other direction than the yaw rate


def examine(samples: Samples, settings: Settings, vehicle: Vehicle, coupled: bool = False) -> Sensors:
    """Follows the checks over the samples of one recording, for the tracer; what is learned on the way is forgotten.

    A stuck yaw rate and a wrong sign leave nothing right that a recording says of the vehicle. A torque that stands
    still is not among them: a moment that nobody declared may turn a vehicle whose torque is held.

    Args:
        coupled: whether velocities were recorded whose product may drive the vehicle: a Coriolis force or a Munk moment
            does so without its thrust, which looks like a wrong sign, and on while a rudder keeps its angle.
    """
    verdicts = [verdict for verdict, _ in follow(settings, vehicle, samples, rest=True)]
    refused = {"yaw_rate stuck"} if coupled else {"yaw_rate stuck", "sign"}
    of_the_model = MODEL_KINDS | {"sign", "torque stuck"} if coupled else MODEL_KINDS
    impossible = [finding for verdict in verdicts for finding in verdict.findings if finding.kind in refused]
    turned = sum(any(finding.kind == "heading reversed" for finding in verdict.findings) for verdict in verdicts)
    return Sensors(
        tuple(_only(verdicts, lambda finding: finding.kind not in of_the_model)),
        tuple(_only(verdicts, lambda finding: finding.kind in of_the_model)),
        impossible[0] if impossible else None,
        turned > 0.5 * len(verdicts),  # a compass is mounted for good
    )


def _only(verdicts: Sequence[Verdict], wanted: Callable[[Finding], bool]) -> list[str]:
    """The sentences of some findings; nothing is put aside."""
    return verdict_sentences(
        replace(verdict, findings=tuple(filter(wanted, verdict.findings)), learn=True) for verdict in verdicts
    )
