"""One iteration as the viewer gets it, and the recording's three clocks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from incsvr.learning.model import Model
from incsvr.plant.words import YAW_WORDS, AxisWords
from service.wire import IterationReport, ModelSnapshot, Points

APPLICATION = "incsvr"
ITERATION, VEHICLE_TIME, WALL_TIME = "iteration", "vehicle_time", "wall_time"

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Frame:
    """What one iteration shows.

    Attributes:
        report: the sets and figures of the iteration.
        snapshot: the model served after it; None where the learner no longer has it.
        seen: when it happened by the clock on the wall [s since 1970]; None for what was learned before we came.
    """

    report: IterationReport
    snapshot: ModelSnapshot | None
    seen: float | None

    @cached_property
    def model(self) -> Model | None:
        """The served model; None before anything was learned."""
        if self.snapshot is None or not self.snapshot.model.is_trained:
            return None
        return self.snapshot.model

    @cached_property
    def curve(self) -> Floats:
        """The learned damping over its trained range, (101, 2) [rad/s, N m]; empty without a model."""
        if self.model is None:
            return np.empty((0, 2))
        low, high = self.model.trained_range or (0.0, 0.0)
        rate = low + (high - low) * np.linspace(0.0, 1.0, 101)
        return np.column_stack((rate, self.model.predict(rate).damping))


def positions(points: Points) -> Floats:
    """(n, 2): yaw rate [rad/s], damping [N m]."""
    return np.array((points.rate, points.damping)).T.reshape(-1, 2)


def clock_text(seconds: float) -> str:
    """The vehicle's time in words: seconds since its start, or the date where it counts from 1970."""
    if seconds > 1e8:
        return datetime.fromtimestamp(seconds).strftime("%Y-%m-%d %H:%M:%S")
    return f"{seconds:.1f} s"


def table(frame: Frame, words: AxisWords = YAW_WORDS) -> str:
    """Markdown; the figures that matter from two metres stand on top, large."""
    report, snapshot = frame.report, frame.snapshot
    span = None if snapshot is None else snapshot.model.trained_range
    model, unit = frame.model, words.effort_unit
    rows = [
        ("Training time", f"{report.training_ms:.1f} ms"),
        ("Error before learning", quantity(report.progressive_mae, unit)),
        *((f"Error on {check.name}", quantity(check.mae, unit)) for check in report.validation),
        ("Noise of a sample", quantity(report.noise, unit)),
        ("Tube of no penalty", "-" if model is None else f"±{quantity(model.epsilon, unit)}"),
        ("Off the optimum at most", quantity(report.certified_error, unit)),
        ("Trained from", "-" if span is None else f"{span[0]:.3g} to {span[1]:.3g} {words.rate_unit}"),
    ]
    untried = report.progressive_mae is None
    headline = "first model" if untried else f"error {quantity(report.progressive_mae, unit)}"
    notes = []
    if not report.trained:
        notes.append("**Nothing new in this batch: the model stays as it was.**")
    if report.change:
        notes.append(f"**{report.change[:1].upper()}{report.change[1:]}**")
    if snapshot is None:
        notes.append("**The learner no longer has this revision's model: the curve is missing.**")
    return "\n".join(
        [
            f"# Iteration {report.iteration}  ·  {headline}",
            f"{report.counts.get('batch', 0)} samples, vehicle time {clock_text(report.time_span[0])} to "
            f"{clock_text(report.time_span[1])}, "
            f"revision {report.revision}",
            *("\n" + note for note in notes),
            "",
            *markdown_table(("Learning", "Value"), rows),
        ]
    )


def samples_table(frame: Frame) -> str:
    """Markdown: how many samples are in each set that the page draws."""
    report = frame.report
    rows = [
        ("New samples", len(report.new)),
        ("Old vectors", len(report.old)),
        ("Support vectors", len(report.support)),
        ("Forgotten", len(report.forgotten)),
        ("Outliers", len(report.outliers)),
        ("Discarded, in the tube", len(report.discarded_tube)),
        ("Discarded, near a vector", len(report.discarded_near)),
        ("Driven by the water", report.counts.get("undriven", 0)),
    ]
    return "\n".join(markdown_table(("Samples", "Count"), rows))


def markdown_table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> list[str]:
    """The lines of a table whose first column is text."""
    lines = [head, [":--", *["--:"] * (len(head) - 1)], *rows]
    return [f"| {' | '.join(map(str, line))} |" for line in lines]


def quantity(value: float | None, unit: str) -> str:
    """Three figures and the unit, never as a power of ten: 0.0000849 N m."""
    if value is None:
        return "-"
    return f"{np.format_float_positional(value, precision=3, fractional=False, trim='-')} {unit}"
