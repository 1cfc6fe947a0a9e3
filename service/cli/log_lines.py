"""What happens to a learner, one line an event: the same in the log of `incsvr serve` and in `incsvr watch`."""

from __future__ import annotations

from incsvr.plant.axes import YAW, Axis
from incsvr.plant.words import words_of
from service.wire import IterationReport, Learning


def iteration_line(report: IterationReport, axis: Axis = YAW) -> str:
    """What an iteration did, in 80 columns, and on a second line what the learner noticed about the vehicle.

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
    """That learning goes on, or why it does not."""
    if learning.state == "learning":
        return f"learning continues at {learning.since:.1f} s"
    return f"learning is {learning.state} since {learning.since:.1f} s: {learning.why}"
