"""The page Learning, Fig. 5–6: one iteration's samples, the learned damping over the yaw rate, and where it is sure."""

from __future__ import annotations

import numpy as np
import rerun as rr

from incsvr.learning.model import Model
from service.wire import SETS, IterationReport
from viewer.axes import Axes, Entry, NumberedAxis, axis_for
from viewer.component_batches import NONE, Lines, strips
from viewer.curve import draw
from viewer.frame import Floats, Frame, positions
from viewer.marks import shape, style
from viewer.painter import SHARP, Mark
from viewer.palette import Colour, Palette
from viewer.recorder import Recorder

RATE, DAMPING = "{rate_title} [{rate_unit}]", "Damping {moment} [{effort_unit}]"
"""Labels of the two axes: templates of `AxisWords`."""
WIDTH, HEIGHT = 1500, 1330
WILD_FACTOR = 1.3  # times the largest damping that was taken seriously
CURVES = ("uncertainty", "tube", "function", "extrapolation", "trained_range", "off_scale")

_MARKS: dict[str, Mark] = {
    "old": "disc",
    "new": "square",
    "support": "halo",
    "forgotten": "cross",
    "discarded_tube": "dash",
    "discarded_near": "bar",
    "outliers": "diamond",
}
# Later is above. A new sample that became a support vector shows both: its square stands in the green halo.
_ORDER = {
    **dict.fromkeys(("uncertainty", "trained_range"), 1.0),
    "support": 10.0,
    "discarded_tube": 12.0,
    "discarded_near": 12.0,
    "forgotten": 14.0,
    "old": 16.0,
    "new": 18.0,
    "function": 22.0,
    "extrapolation": 22.0,
    "tube": 23.0,  # above the curve, which is wider than most tubes
    "outliers": 24.0,
    "off_scale": 24.0,
}


class LearningPage:
    """Logs iterations below learning/. The axes begin at ±`rate` [rad/s] and only ever grow."""

    def __init__(self, rec: Recorder, palette: Palette, rate: float) -> None:
        self._rec, self._palette = rec, palette
        self._reach = (rate, 0.0)
        self._shown: dict[str, bool] = {}  # whether a set has anything on the screen
        self._drawn: dict[str, bytes] = {}  # the points of each curve on the screen
        self._axes: Axes | None = None
        for name, mark in _MARKS.items():
            rec.log(f"learning/{name}", *style(mark, set_colour(palette, name), order=_ORDER[name]), static=True)
        for name, (colour, width) in {
            "uncertainty": (palette.band, 0.8),
            "tube": (palette.tube, 0.8),
            "function": (palette.function, 2.6),
            "extrapolation": (palette.function, 1.8),
            "trained_range": (palette.frame, 1.0),
            "off_scale": (palette.outlier, 1.6),
        }.items():
            rec.strip(f"learning/{name}", colour, width, _ORDER[name])

    def log(self, frame: Frame) -> Axes:
        """One iteration, at the clocks that are set; the axes that it is drawn on."""
        model = frame.model
        axes, report, rec = self._follow(frame.report, model), frame.report, self._rec
        for name in SETS:
            at = positions(getattr(report, name))
            if len(at) or self._shown.get(name, True):
                rec.log(f"learning/{name}", *shape(_MARKS[name], at, axes))
            self._shown[name] = bool(len(at))
        curves: dict[str, Lines] = {} if model is None else draw(model, axes)
        curves["off_scale"] = _arrows(report, axes)
        for name in CURVES:
            lines = curves.get(name, NONE)
            drawn = np.concatenate(lines).tobytes() if len(lines) else b""
            if drawn != self._drawn.get(name):
                rec.log(f"learning/{name}", strips(lines))
            self._drawn[name] = drawn
        return axes

    def _follow(self, report: IterationReport, model: Model | None) -> Axes:
        """Widens the axes where this iteration needs it, and draws them anew then."""
        self._reach = _reach(report, model, *self._reach)
        rate, damping = self._reach[0], _with_outliers(report, self._reach[1])
        if self._axes is not None and rate <= self._axes.x.high and damping <= self._axes.y.high:
            return self._axes
        words = self._rec.words
        x, y = symmetric(rate, words.fill(RATE)), symmetric(damping, words.fill(DAMPING))
        self._axes = Axes(x, y, WIDTH, HEIGHT, legend=legend(self._palette), font=32)
        log_axes(
            self._rec, "learning/axes", self._axes, self._palette, [f"learning/{name}" for name in (*SETS, *CURVES)]
        )
        return self._axes


def symmetric(reach: float, label: str) -> NumberedAxis:
    """An axis from −reach to reach with air, so that a run that widens its range redraws it a few times only."""
    return axis_for(-1.15 * reach, 1.15 * reach, label, ticks=10)


def set_colour(palette: Palette, name: str) -> Colour:
    """The colour of a set of samples."""
    colours = {"outliers": palette.outlier, "discarded_tube": palette.discarded, "discarded_near": palette.discarded}
    colour: Colour = colours[name] if name in colours else getattr(palette, name)
    return colour


def legend(palette: Palette) -> tuple[tuple[Entry, ...], ...]:
    """Every sign of the page in words."""
    words = {
        "old": "Old vectors",
        "new": "New samples",
        "support": "Support vectors",
        "forgotten": "Forgotten",
        "outliers": "Outliers",
        "discarded_tube": "Discarded, in the tube",
        "discarded_near": "Discarded, near a vector",
    }
    signs = {name: Entry(_MARKS[name], set_colour(palette, name), text) for name, text in words.items()}
    return (
        (signs["old"], signs["new"], signs["support"]),
        (signs["forgotten"], signs["outliers"], Entry("arrow", palette.outlier, "Beyond the axes")),
        (signs["discarded_tube"], signs["discarded_near"], Entry("band", palette.band, "95 % of samples")),
        (
            Entry("line", palette.function, "Learned damping"),
            Entry("dashes", palette.function, "Extrapolated"),
            Entry("tube", palette.tube, "Tube of no penalty"),
        ),
    )


def log_axes(rec: Recorder, path: str, axes: Axes, palette: Palette, entities: list[str]) -> None:
    """The axes' picture at `path`, and for each of `entities` the way from physical units onto it."""
    rec.log(
        path,
        rr.EncodedImage(contents=axes.png(palette), media_type="image/png", draw_order=-10.0),
    )
    rec.log(path, rr.Transform3D(scale=1.0 / SHARP))
    for entity in entities:
        log_transform(rec, axes, entity)


def log_transform(rec: Recorder, axes: Axes, entity: str) -> None:
    """The way from physical units onto the axes' canvas, for what `entity` shows."""
    (sx, sy), (tx, ty) = axes.scale, axes.translation
    rec.log(entity, rr.Transform3D(translation=[tx, ty, 0.0], scale=[sx, sy, 1.0]))


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
    sets = (report.new, report.forgotten, report.outliers)
    if max((abs(value) for points in sets for value in points.damping), default=0.0) <= axes.y.high:
        return NONE
    at = np.concatenate([positions(points) for points in sets])
    beyond = at[(np.abs(at[:, 1]) > axes.y.high) & (np.abs(at[:, 0]) <= axes.x.high)]
    beyond = np.unique(beyond, axis=0)
    dx, dy = axes.size(11.0)
    side = np.sign(beyond[:, 1])[:, None]
    tip = np.column_stack((beyond[:, 0], side[:, 0] * (axes.y.high - 0.5 * dy)))
    back = np.concatenate((np.full_like(side, dx), -side * 1.4 * dy), axis=1)
    mirrored = back * np.array([-1.0, 1.0])
    return np.stack((tip + back, tip, tip + mirrored), axis=1)
