"""The error curve, Fig. 7: how far the served damping is off, iteration by iteration, from the untrained model on.

Every curve is of one predictor: what is served, with its continuation beyond the learned rates.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from math import ceil, log2

import numpy as np
import rerun as rr
from rerun.components import Radius

from service.wire import IterationReport
from viewer.axes import Axes, Entry, axis_for
from viewer.component_batches import dashed, strips
from viewer.component_batches import points as points_at
from viewer.frame import Floats, Frame
from viewer.learning import log_axes
from viewer.painter import Mark
from viewer.palette import Palette
from viewer.recorder import Recorder

WIDTH, HEIGHT = 1000, 425
MAX_POINTS = 120  # of a curve at most: a run of ten hours must not log its whole past with every iteration
PROGRESSIVE = "progressive"
DASHES = (None, 0.028, 0.009)  # of each curve in turn, in parts of the axis
MARKS: tuple[Mark, ...] = ("line", "dashes", "dots")


class ErrorPage:
    """Logs below error/: the figures as scalars, and the curves up to the iteration over an iteration axis."""

    def __init__(self, rec: Recorder, palette: Palette) -> None:
        self._rec, self._palette = rec, palette
        self._curves: dict[str, list[tuple[float, float]]] = {}
        self._axes: Axes | None = None

    def log(self, frame: Frame) -> None:
        """One iteration, at the clocks that are set."""
        rec = self._rec
        for name, value in self.remember(frame.report).items():
            rec.log(f"error/{name}", rr.Scalars(value))
        curves = {name: thinned(curve) for name, curve in self._curves.items()}
        axes = self._follow(frame.report.iteration, curves)
        for number, (name, points) in enumerate(curves.items()):
            dash = DASHES[number % len(DASHES)]
            on_axes = np.column_stack((points[:, 0], np.minimum(points[:, 1], axes.y.high)))
            line = strips(dashed(on_axes, None if dash is None else dash * axes.x.high))
            now = points[-1:] if points[-1, 1] <= axes.y.high else points[:0]
            rec.log(f"error/curve/{name}", line, points_at(now))

    def remember(self, report: IterationReport) -> dict[str, float]:
        """Adds an iteration's errors to the curves; the errors by their names."""
        values = {check.name: check.mae for check in report.validation}
        if report.progressive_mae is not None:
            values[PROGRESSIVE] = report.progressive_mae
        for check in report.validation:
            if report.iteration == 1 and check.untrained is not None:
                self._curves[check.name] = [(0.0, check.untrained)]
        for name, value in values.items():
            curve = self._curves.setdefault(name, [])
            # Whoever replays the past may repeat some of it.
            del curve[bisect_right(curve, (report.iteration - 0.5,)) :]
            curve.append((float(report.iteration), value))
        return values

    def _follow(self, iteration: int, curves: dict[str, Floats]) -> Axes:
        """Widens the axes where the curves need it; a new curve gets its line style.

        One wild error, as that of the untrained model or on the first batch with a new range, must not press all others
        flat: what lies beyond twice the median runs along the frame. Its figure stands in the table.
        """
        learned = [points[points[:, 0] > 0.0, 1] for points in curves.values()]
        values = np.concatenate(learned) if learned else np.ones(1)
        highest = min(values.max(), 2.0 * float(np.median(values)))
        axes, shown = self._axes, {entry.text for row in (self._axes.legend if self._axes else ()) for entry in row}
        names = {name: _words(name) for name in self._curves}
        if axes is not None and iteration <= axes.x.high and highest <= axes.y.high and set(names.values()) <= shown:
            return axes
        colours = (self._palette.before, self._palette.old, self._palette.support, self._palette.outlier)
        entries = []
        for number, (name, text) in enumerate(names.items()):
            colour = colours[number % len(colours)]
            entries.append(Entry(MARKS[number % len(MARKS)], colour, text))
            self._rec.log(
                f"error/curve/{name}",
                rr.LineStrips2D.from_fields(colors=colour, radii=Radius.ui_points(1.8)),
                rr.Points2D.from_fields(colors=colour, radii=Radius.ui_points(5.0)),
                static=True,
            )
        reach = 25.0 * 2.0 ** max(0, ceil(log2(iteration / 25.0)))
        self._axes = Axes(
            axis_for(0.0, reach, "Iteration"),
            axis_for(0.0, 1.3 * highest or 1.0, _label(self._curves, self._rec.words.effort_unit), ticks=4),
            WIDTH,
            HEIGHT,
            legend=tuple(tuple(entries[k : k + 3]) for k in range(0, len(entries), 3)),
        )
        log_axes(self._rec, "error/axes", self._axes, self._palette, [f"error/curve/{name}" for name in self._curves])
        return self._axes


def thinned(curve: Sequence[tuple[float, float]]) -> Floats:
    """At most MAX_POINTS of the points as (n, 2), both ends among them, evenly spread."""
    few = np.unique(np.linspace(0, len(curve) - 1, min(MAX_POINTS, len(curve))).astype(int))
    return np.array([curve[k] for k in few])


def _words(name: str) -> str:
    return "Each new batch" if name == PROGRESSIVE else f"Validation {name}"


def _label(curves: dict[str, list[tuple[float, float]]], unit: str) -> str:
    """The axis' label, with the errors of the untrained model, at which no axis reaches."""
    begins = [f"{curve[0][1]:.0f}" for curve in curves.values() if curve[0][0] == 0.0]
    return f"Mean absolute error [{unit}]" + (f"; untrained: {', '.join(begins)}" if begins else "")
