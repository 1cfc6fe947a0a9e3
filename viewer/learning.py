"""The page Learning, Fig. 5–6: one iteration's samples, the learned damping over the yaw rate, and where it is sure."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from incsvr.learning.model import Model
from incsvr.plant.words import AxisWords
from service.wire import SETS, IterationReport
from viewer import palette
from viewer.frame import Floats, Frame, positions
from viewer.recorder import Recorder
from viewer.xy_plot import Axes, Lines, Plot, Sign

WILD_FACTOR = 1.3  # times the largest damping that was taken seriously
CURVES = ("uncertainty", "tube", "function", "extrapolation", "trained_range", "off_scale")
NONE: Floats = np.empty((0, 2, 2))


class LearningPage:
    """Logs iterations below learning/. The axes begin at ±`rate` [rad/s]."""

    def __init__(self, rec: Recorder, rate: float) -> None:
        self._reach = (rate, 0.0)
        entities = {f"learning/{name}": sign for name, sign in signs().items()}
        self._plot = Plot(rec, "learning/axes", entities, labels(rec.words))

    def log(self, frame: Frame) -> tuple[float, float]:
        """One iteration, at the clocks that are set; the |rate| and |damping| that its axes hold."""
        report = frame.report
        self._reach = _reach(report, frame.model, *self._reach)
        held = self._reach[0], _with_outliers(report, self._reach[1])
        axes = self._plot.hold(*held)
        for name in SETS:
            self._plot.points(f"learning/{name}", positions(getattr(report, name)))
        curves: dict[str, Lines] = {} if frame.model is None else draw(frame.model, axes)
        curves["off_scale"] = _arrows(report, axes)
        for name in CURVES:
            self._plot.lines(f"learning/{name}", curves.get(name, NONE))
        return held


def labels(words: AxisWords) -> tuple[str, str]:
    """What the two axes of the plot are called, with their units."""
    return f"{words.rate_title} [{words.rate_unit}]", f"Damping {words.moment} [{words.effort_unit}]"


def signs() -> dict[str, Sign]:
    """Every sign of the page, in the order of the legend's columns.

    Later is above. A new sample that became a support vector shows both: its square stands in the green halo.
    """
    return {
        "old": Sign("Old vectors", palette.OLD, "o", size=4.5, order=16.0),
        "forgotten": Sign("Forgotten", palette.FORGOTTEN, "x", order=14.0),
        "discarded_tube": Sign("Discarded, in the tube", palette.DISCARDED, "_", order=12.0),
        "function": Sign("Learned damping", palette.FUNCTION, line="-", size=2.6, order=22.0),
        "new": Sign("New samples", palette.NEW, "s", order=18.0),
        "outliers": Sign("Outliers", palette.OUTLIER, "D", order=24.0),
        "discarded_near": Sign("Discarded, near a vector", palette.DISCARDED, "|", order=12.0),
        "extrapolation": Sign("Extrapolated", palette.FUNCTION, line="--", size=1.8, order=22.0),
        "support": Sign("Support vectors", palette.SUPPORT, "o", size=9.5, order=10.0),
        "off_scale": Sign("Beyond the axes", palette.OUTLIER, line="^", size=4.0, order=24.0),
        "uncertainty": Sign("95 % of samples", palette.BAND, line="|||", size=0.8, order=1.0),
        # above the curve, which is wider than most tubes
        "tube": Sign("Tube of no penalty", palette.TUBE, line="-", size=0.8, order=23.0),
        "trained_range": Sign("", palette.FRAME, line="-", size=1.0, order=1.0),
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


def draw(model: Model, axes: Axes, step: float = 9.0) -> dict[str, Lines]:
    """The learned curve over the whole axis, a point each `step` units of the canvas, as strips in rad/s and N m."""
    low, high = model.trained_range or (0.0, 0.0)
    rate = np.unique(np.concatenate((np.arange(-axes.x, axes.x, axes.size(step)[0]), (low, high))))
    said = model.predict(rate)
    curve = np.column_stack((rate, said.damping))
    tube = np.array([0.0, model.epsilon])
    # Over several velocities it is a slice, which may be steeper than all samples.
    inside = np.abs(said.damping) <= axes.y
    known, unknown = runs(curve, ~said.extrapolated & inside), runs(curve, said.extrapolated & inside)
    # Beyond the samples it is dashed from there outwards.
    broken = [dashes(run if run[0, 0] > 0.0 else run[::-1]) for run in unknown]
    return {
        "function": known,
        "tube": [run + side * tube for run in known for side in (-1.0, 1.0)],
        "uncertainty": _hatched(curve, 1.96 * said.sigma, axes),
        "extrapolation": [dash for each in broken for dash in each],
        "trained_range": [dot for at in (low, high) for dot in _upright(at, axes)],
    }


def runs(curve: Floats, chosen: NDArray[np.bool_]) -> list[Floats]:
    """The parts of the (n, 2) curve where `chosen` (n,) holds, each at least two points long."""
    ends = np.flatnonzero(np.diff(chosen)) + 1
    parts = zip(np.split(curve, ends), np.split(chosen, ends), strict=True)
    return [part for part, wanted in parts if wanted[0] and len(part) > 1]


def _hatched(curve: Floats, doubt: Floats, axes: Axes) -> list[Floats]:
    """The area within ±doubt (n,) [N m] of the curve (n, 2), on the axes."""
    if not np.isfinite(doubt).all():
        return []
    rate, damping = curve.T
    ends = (np.column_stack((rate, np.clip(damping + side * doubt, -axes.y, axes.y))) for side in (-1.0, 1.0))
    return hatch(*ends)


def hatch(below: Floats, above: Floats) -> list[Floats]:
    """The area between two curves (n, 2): both, and strokes between them."""
    # One line runs through all strokes: up the first, along the edge, down the second, along the other edge, and on.
    strokes = np.stack((below, above), axis=1)
    strokes[1::2] = strokes[1::2, ::-1]
    return [below, above, strokes.reshape(-1, 2)]


def dashes(curve: Floats, on: int = 3, off: int = 2) -> list[Floats]:
    """The (n, 2) curve with gaps: so many steps of line, so many of nothing."""
    return [curve[k : k + on + 1] for k in range(0, len(curve) - 1, on + off)]


def _upright(at: float, axes: Axes, step: float = 7.0) -> list[Floats]:
    """A dotted upright line at this rate, a dot each other `step` units of the canvas."""
    y = np.arange(-axes.y, axes.y, axes.size(step)[1])
    return dashes(np.column_stack((np.full_like(y, at), y)), on=1, off=1)
