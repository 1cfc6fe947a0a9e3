"""The table of one iteration: its counts, times and certificate, in words."""

from __future__ import annotations

import numpy as np

from viewer.frame import Frame, clock_text


def table(frame: Frame) -> str:
    """Markdown; the figures that matter from two metres stand on top, large."""
    report, snapshot = frame.report, frame.snapshot
    left = [
        ("New samples", len(report.new)),
        ("Old vectors", len(report.old)),
        ("Support vectors", len(report.support)),
        ("Forgotten", len(report.forgotten)),
        ("Outliers", len(report.outliers)),
        ("Discarded, in the tube", len(report.discarded_tube)),
        ("Discarded, near a vector", len(report.discarded_near)),
    ]
    span = None if snapshot is None else snapshot.trained_range
    right = [
        ("Training time", f"{report.training_ms:.1f} ms"),
        ("Error before learning", quantity(report.progressive_mae, "N m")),
        *((f"Error on {check.name}", quantity(check.mae, "N m")) for check in report.validation),
        ("Noise of a sample", quantity(report.sigma, "N m")),
        ("Off the optimum at most", quantity(report.certified_error, "N m")),
        ("Trained from", "-" if span is None else f"{span[0]:.3g} to {span[1]:.3g} rad/s"),
    ]
    rows = max(len(left), len(right))
    cells_left = [(name, str(count)) for name, count in left] + [("", "")] * (rows - len(left))
    cells_right = right + [("", "")] * (rows - len(right))
    lines = [f"| {a} | {b} | {c} | {d} |" for (a, b), (c, d) in zip(cells_left, cells_right, strict=True)]
    notes = []
    if not report.trained:
        notes.append("**Nothing new in this batch: the model stays as it was.**")
    if report.change:
        notes.append(f"**{report.change[:1].upper()}{report.change[1:]}**")
    if snapshot is None:
        notes.append("**The learner no longer has this revision's model: the curve is missing.**")
    return "\n".join(
        [
            f"# Iteration {report.iteration}  ·  {headline(frame)}",
            f"{report.counts.get('batch', 0)} samples, vehicle time {clock_text(report.time_span[0])} to "
            f"{clock_text(report.time_span[1])}, "
            f"revision {report.revision}",
            *("\n" + note for note in notes),
            "",
            "| Samples | Count | Learning | Value |",
            "|:--|--:|:--|--:|",
            *lines,
        ]
    )


def headline(frame: Frame) -> str:
    """The one figure that says how good the model is."""
    report = frame.report
    if report.progressive_mae is not None:
        return f"error {quantity(report.progressive_mae, 'N m')}"
    return "first model"


def quantity(value: float | None, unit: str) -> str:
    """Three figures and the unit, never as a power of ten: 0.0000849 N m."""
    if value is None:
        return "-"
    return f"{np.format_float_positional(value, precision=3, fractional=False, trim='-')} {unit}"
