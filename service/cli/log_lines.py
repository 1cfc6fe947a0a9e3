"""The lines that report a learner's events, in the log of `incsvr serve` and in `incsvr status --follow` alike."""

from __future__ import annotations

from incsvr.plant.axes import YAW, Axis
from incsvr.plant.words import words_of
from service.wire import IterationReport, Learning


def iteration_line(report: IterationReport, axis: Axis = YAW) -> str:
    """The line of an iteration, in 80 columns, with a second line if the learner noticed a change of the vehicle.

    The error is that of the model before on the batch, before it was learned.
    """
    counts = report.counts
    did = "nothing new"
    if report.trained:
        did = f"{counts['new']} new, {counts['forgotten']} forgotten, {counts['outliers']} out"
    unit = words_of(axis).effort_unit
    error = "" if report.progressive_mae is None else f", error {report.progressive_mae:.3g} {unit}"
    line = f"iteration {report.iteration}, {report.t:.0f} s: {did}, {counts['support']} vectors{error}"
    return line if report.change is None else f"{line}\n  {report.change}"


def learning_line(learning: Learning) -> str:
    """The line that reports the state of learning, with the reason if it has stopped."""
    if learning.state == "learning":
        return f"learning continues at {learning.since:.1f} s"
    return f"learning is {learning.state} since {learning.since:.1f} s: {learning.why}"
