"""The error curve, Fig. 7: how far the learned damping is off, iteration by iteration."""

from __future__ import annotations

from bisect import bisect_right
from math import ceil, log2

import numpy as np
import rerun as rr
from rerun.components import Radius

from service.wire import IterationReport
from viewer.frame import Floats, Frame
from viewer.learning import log_plate
from viewer.palette import Palette
from viewer.plate import Entry, Plate, axis_for
from viewer.recorder import Recorder
from viewer.strips import dashed, strips

WIDTH, HEIGHT = 1000, 425
POINTS = 120  # of a curve at most: a run of ten hours must not log its whole past with every iteration
PROGRESSIVE = "progressive"
DASHES = (None, 0.024, 0.012, 0.006)  # of each curve in turn, in parts of the axis


class ErrorPage:
    """Logs below error/: the figures as scalars, and the curves up to the iteration over an iteration axis."""

    def __init__(self, rec: Recorder, palette: Palette) -> None:
        self._rec, self._palette = rec, palette
        self._curves: dict[str, list[tuple[float, float]]] = {}
        self._plate: Plate | None = None

    def log(self, frame: Frame) -> None:
        """One iteration, at the clocks that are set."""
        rec = self._rec
        for name, value in self.remember(frame.report).items():
            rec.log(f"error/{name}", rr.Scalars(value))
        self._follow(frame.report.iteration)
        reach = 25.0 if self._plate is None else self._plate.x.high
        for number, (name, curve) in enumerate(self._curves.items()):
            points, dash = thinned(np.array(curve)), DASHES[number % len(DASHES)]
            line = strips(dashed(points, None if dash is None else dash * reach))
            rec.log(f"error/curve/{name}", line, rr.Points2D.from_fields(positions=points[-1:]))

    def remember(self, report: IterationReport) -> dict[str, float]:
        """Adds an iteration's errors to the curves; the errors by their names."""
        values = {check.name: check.mae for check in report.validation}
        if report.progressive_mae is not None:
            values[PROGRESSIVE] = report.progressive_mae
        for name, value in values.items():
            curve = self._curves.setdefault(name, [])
            # Whoever replays the past may repeat some of it.
            del curve[bisect_right(curve, (report.iteration - 0.5,)) :]
            curve.append((float(report.iteration), value))
        return values

    def _follow(self, iteration: int) -> None:
        """Widens the axes where the curves need it; a new curve gets its line style."""
        highest = max((value for curve in self._curves.values() for _, value in curve), default=0.0)
        plate, shown = self._plate, {entry.text for row in (self._plate.legend if self._plate else ()) for entry in row}
        names = {name: _words(name) for name in self._curves}
        if plate is not None and iteration <= plate.x.high and highest <= plate.y.high and set(names.values()) <= shown:
            return
        colours = (self._palette.before, self._palette.old, self._palette.support, self._palette.outlier)
        entries = []
        for number, (name, text) in enumerate(names.items()):
            colour = colours[number % len(colours)]
            entries.append(Entry("line" if DASHES[number % len(DASHES)] is None else "dashes", colour, text))
            self._rec.log(
                f"error/curve/{name}",
                rr.LineStrips2D.from_fields(colors=colour, radii=Radius.ui_points(1.8)),
                rr.Points2D.from_fields(colors=colour, radii=Radius.ui_points(5.0)),
                static=True,
            )
        reach = 25.0 * 2.0 ** max(0, ceil(log2(iteration / 25.0)))
        self._plate = Plate(
            axis_for(0.0, reach, "Iteration"),
            axis_for(0.0, 1.4 * highest or 1.0, "Mean absolute error [N m]", ticks=4),
            WIDTH,
            HEIGHT,
            legend=tuple(tuple(entries[k : k + 2]) for k in range(0, len(entries), 2)),
        )
        log_plate(self._rec, "error/axes", self._plate, self._palette, [f"error/curve/{name}" for name in self._curves])


def thinned(curve: Floats) -> Floats:
    """At most POINTS of the (n, 2) points, both ends among them, evenly spread."""
    if len(curve) <= POINTS:
        return curve
    kept: Floats = curve[np.unique(np.linspace(0, len(curve) - 1, POINTS).astype(int))]
    return kept


def _words(name: str) -> str:
    return "New batch, before it is learned" if name == PROGRESSIVE else f"Validation {name}"
