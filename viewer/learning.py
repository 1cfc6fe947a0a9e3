"""The page Learning, Fig. 5–6: one iteration's samples, the learned damping over the yaw rate, and where it is sure."""

from __future__ import annotations

import numpy as np
import rerun as rr

from incsvr.learning.model import Model
from service.wire import SETS, IterationReport
from viewer.axes import Axes, Sign, place, style
from viewer.curve import NONE, Lines, draw
from viewer.frame import Floats, Frame, positions
from viewer.palette import Palette
from viewer.recorder import Recorder

RATE, DAMPING = "{rate_title} [{rate_unit}]", "Damping {moment} [{effort_unit}]"
"""Labels of the two axes: templates of `AxisWords`."""
WILD_FACTOR = 1.3  # times the largest damping that was taken seriously
CURVES = ("uncertainty", "tube", "function", "extrapolation", "trained_range", "off_scale")
# Later is above. A new sample that became a support vector shows both: its square stands in the green halo.
_ORDER = {
    "support": 10.0,
    "discarded_tube": 12.0,
    "discarded_near": 12.0,
    "forgotten": 14.0,
    "old": 16.0,
    "new": 18.0,
    "outliers": 24.0,
}


class LearningPage:
    """Logs iterations below learning/. The axes begin at ±`rate` [rad/s] and only ever grow."""

    def __init__(self, rec: Recorder, palette: Palette, rate: float) -> None:
        self._rec, self._palette = rec, palette
        self._reach = (rate, 0.0)
        self._drawn: dict[str, bytes] = {}  # what each set and curve has on the screen
        self._axes: Axes | None = None
        self._signs = signs(palette)
        for name, order in _ORDER.items():
            style(rec, f"learning/{name}", self._signs[name], order)
        for name, colour, width, order in (
            ("uncertainty", palette.band, 0.8, 1.0),
            ("trained_range", palette.frame, 1.0, 1.0),
            ("function", palette.function, 2.6, 22.0),
            ("extrapolation", palette.function, 1.8, 22.0),
            ("tube", palette.tube, 0.8, 23.0),  # above the curve, which is wider than most tubes
            ("off_scale", palette.outlier, 1.6, 24.0),
        ):
            rec.strip(f"learning/{name}", colour, width, order)

    def log(self, frame: Frame) -> Axes:
        """One iteration, at the clocks that are set; the axes that it is drawn on."""
        before, axes, report = self._axes, self._follow(frame.report, frame.model), frame.report
        for name in SETS:
            at = positions(getattr(report, name))
            if self._is_news(name, at.tobytes()) or axes is not before:
                place(self._rec, f"learning/{name}", self._signs[name], at, axes)
        curves: dict[str, Lines] = {} if frame.model is None else draw(frame.model, axes)
        curves["off_scale"] = _arrows(report, axes)
        for name in CURVES:
            lines = curves.get(name, NONE)
            if self._is_news(name, np.concatenate(lines).tobytes() if len(lines) else b""):
                self._rec.log(f"learning/{name}", rr.LineStrips2D(list(lines)))
        return axes

    def _is_news(self, name: str, drawn: bytes) -> bool:
        before, self._drawn[name] = self._drawn.get(name), drawn
        return drawn != before

    def _follow(self, report: IterationReport, model: Model | None) -> Axes:
        """Widens the axes where this iteration needs it, and draws them anew then."""
        self._reach = _reach(report, model, *self._reach)
        rate, damping = self._reach[0], _with_outliers(report, self._reach[1])
        if self._axes is None or rate > self._axes.x or damping > self._axes.y:
            words = self._rec.words
            self._axes = Axes.around(rate, damping, (words.fill(RATE), words.fill(DAMPING)))
            entities = [f"learning/{name}" for name in (*SETS, *CURVES)]
            self._axes.log(self._rec, "learning/axes", self._palette, list(self._signs.values()), entities)
        return self._axes


def signs(palette: Palette) -> dict[str, Sign]:
    """Every sign of the page, in the order of the legend's columns."""
    return {
        "old": Sign("Old vectors", palette.old, "o", size=4.5),
        "forgotten": Sign("Forgotten", palette.forgotten, "x"),
        "discarded_tube": Sign("Discarded, in the tube", palette.discarded, "_"),
        "function": Sign("Learned damping", palette.function, line="-"),
        "new": Sign("New samples", palette.new, "s"),
        "outliers": Sign("Outliers", palette.outlier, "D"),
        "discarded_near": Sign("Discarded, near a vector", palette.discarded, "|"),
        "extrapolation": Sign("Extrapolated", palette.function, line="--", size=3.0),
        "support": Sign("Support vectors", palette.support, "o", size=9.5),
        "off_scale": Sign("Beyond the axes", palette.outlier, "^"),
        "uncertainty": Sign("95 % of samples", palette.band, line="-", size=14.0),
        "tube": Sign("Tube of no penalty", palette.tube, line="-", size=2.0),
    }


def _reach(report: IterationReport, model: Model | None, rate: float, damping: float) -> tuple[float, float]:
    """The largest |rate| and |damping| so far of what the learner took seriously."""
    serious = [report.support, report.old, report.discarded_tube, report.discarded_near]
    if model is None or not any(len(points) for points in serious):
        serious.append(report.new)
    for points in serious:
        rate = max([rate, *map(abs, points.rate)])
        damping = max([damping, *map(abs, points.damping)])
    return rate, damping


def _with_outliers(report: IterationReport, damping: float) -> float:
    """What the axis must hold: samples beyond a wild one's distance get an arrow at the frame instead.

    A single wild sample must not press everything else flat, today or for the rest of the run.
    """
    others = (abs(value) for points in (report.new, report.forgotten, report.outliers) for value in points.damping)
    return max([damping, *(value for value in others if value <= WILD_FACTOR * damping)])


def _arrows(report: IterationReport, axes: Axes) -> Floats:
    """An arrow at the frame for each sample beyond the axes, as (n, 3, 2) strips pointing to it."""
    at = np.concatenate([positions(points) for points in (report.new, report.forgotten, report.outliers)])
    beyond = np.unique(at[(np.abs(at[:, 1]) > axes.y) & (np.abs(at[:, 0]) <= axes.x)], axis=0)
    dx, dy = axes.size(11.0)
    side = np.sign(beyond[:, 1])[:, None]
    tip = np.column_stack((beyond[:, 0], side[:, 0] * (axes.y - 0.5 * dy)))
    back = np.concatenate((np.full_like(side, dx), -side * 1.4 * dy), axis=1)
    return np.stack((tip + back, tip, tip + back * np.array([-1.0, 1.0])), axis=1)
