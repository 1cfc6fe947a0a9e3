"""The page Learning, Fig. 5–6: one iteration's samples, the learned damping over the yaw rate, and where it is sure."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from incsvr.learning.model import Model
from service.wire import SETS, IterationReport
from viewer.axes import Axes, Sign, place, style
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


Lines = Sequence[Floats] | Floats
"""Lines through (n, 2) points each, or (m, n, 2) for m lines of equal length."""
NONE: Floats = np.empty((0, 2, 2))
CURVE_STEP = 9.0  # canvas units between two points of the curve


def draw(model: Model, axes: Axes) -> dict[str, Lines]:
    """The learned curve over the whole axis, as strips in rad/s and N m."""
    low, high = model.trained_range or (0.0, 0.0)
    rate = np.unique(np.concatenate((np.arange(-axes.x, axes.x, axes.size(CURVE_STEP)[0]), (low, high))))
    said = model.predict(rate)
    curve = np.column_stack((rate, said.damping))
    tube = np.array([0.0, model.epsilon])
    # Over several velocities it is a slice, which may be steeper than all samples.
    inside = np.abs(said.damping) <= axes.y
    known, unknown = runs(curve, ~said.extrapolated & inside), runs(curve, said.extrapolated)
    broken = [dashes(run if run[0, 0] > 0.0 else run[::-1], axes.y) for run in unknown]
    return {
        "function": known,
        "tube": [run + side * tube for run in known for side in (-1.0, 1.0)],
        "uncertainty": _hatch(curve, 1.96 * said.sigma, axes),
        "extrapolation": np.concatenate(broken) if broken else NONE,
        "trained_range": np.concatenate([_dotted(at, axes) for at in (low, high)]),
    }


def runs(curve: Floats, chosen: NDArray[np.bool_]) -> list[Floats]:
    """The parts of the (n, 2) curve where `chosen` (n,) holds, each at least two points long."""
    ends = np.flatnonzero(np.diff(chosen)) + 1
    parts = zip(np.split(curve, ends), np.split(chosen, ends), strict=True)
    return [part for part, wanted in parts if wanted[0] and len(part) > 1]


def _hatch(curve: Floats, doubt: Floats, axes: Axes) -> list[Floats]:
    """The area within ±doubt (n,) [N m] of the curve (n, 2), on the axes: its two edges and strokes between them."""
    if not np.isfinite(doubt).all():
        return []
    rate, damping = curve.T
    below, above = (np.column_stack((rate, np.clip(damping + side * doubt, -axes.y, axes.y))) for side in (-1.0, 1.0))
    # One line runs through all strokes: up the first, along the edge, down the second, along the other edge, and on.
    strokes = np.stack((below, above), axis=1)
    strokes[1::2] = strokes[1::2, ::-1]
    return [below, above, strokes.reshape(-1, 2)]


def dashes(curve: Floats, reach: float) -> Floats:
    """The part of the (n, 2) curve within ±reach, with gaps: two steps of line, two of nothing; (m, 3, 2)."""
    drawn = curve[1:][np.abs(curve[1:, 1]) <= reach]
    whole = len(drawn) // 4
    return drawn[: 4 * whole].reshape(whole, 4, 2)[:, :3]


def _dotted(at: float, axes: Axes) -> Floats:
    """A dotted upright line at this rate, as (n, 2, 2) strips."""
    dot = axes.size(7.0)[1]
    y = np.arange(-axes.y, axes.y, 2.5 * dot)
    dots = np.full((y.size, 2, 2), at)
    dots[:, 0, 1], dots[:, 1, 1] = y, y + dot
    return dots
