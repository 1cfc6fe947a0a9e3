"""The tables of one iteration: what was learned with its errors and certificate, and the counts of its samples."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.plant.words import YAW_WORDS, AxisWords
from viewer.frame import Frame, clock_text


def table(frame: Frame, words: AxisWords = YAW_WORDS) -> str:
    """Markdown; the figures that matter from two metres stand on top, large."""
    report, snapshot = frame.report, frame.snapshot
    span = None if snapshot is None else snapshot.trained_range
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
    notes = []
    if not report.trained:
        notes.append("**Nothing new in this batch: the model stays as it was.**")
    if report.change:
        notes.append(f"**{report.change[:1].upper()}{report.change[1:]}**")
    if snapshot is None:
        notes.append("**The learner no longer has this revision's model: the curve is missing.**")
    return "\n".join(
        [
            f"# Iteration {report.iteration}  ·  {headline(frame, unit)}",
            f"{report.counts.get('batch', 0)} samples, vehicle time {clock_text(report.time_span[0])} to "
            f"{clock_text(report.time_span[1])}, "
            f"revision {report.revision}",
            *("\n" + note for note in notes),
            "",
            *_rows(("Learning", "Value"), rows),
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
    return "\n".join(_rows(("Samples", "Count"), [(name, str(count)) for name, count in rows]))


def _rows(head: tuple[str, str], rows: Sequence[tuple[str, str]]) -> list[str]:
    return [f"| {head[0]} | {head[1]} |", "|:--|--:|", *(f"| {name} | {value} |" for name, value in rows)]


def headline(frame: Frame, unit: str = YAW_WORDS.effort_unit) -> str:
    """The one figure that says how good the model is."""
    report = frame.report
    if report.progressive_mae is not None:
        return f"error {quantity(report.progressive_mae, unit)}"
    return "first model"


def quantity(value: float | None, unit: str) -> str:
    """Three figures and the unit, never as a power of ten: 0.0000849 N m."""
    if value is None:
        return "-"
    return f"{np.format_float_positional(value, precision=3, fractional=False, trim='-')} {unit}"
