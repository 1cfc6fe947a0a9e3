"""The page Slices of a learner over several velocities: damping at three values of another one, and where it drove.

A row for each further velocity. On the left the damping over the own velocity, with this one at a slow, a usual and a
fast value of the vectors and all others as usual; dashed where nothing was driven. On the right the plane of both
velocities: the vectors, and the newest batch.
"""

from __future__ import annotations

import numpy as np

from incsvr.learning.model import Model
from incsvr.learning.several_velocities.surface import Several
from viewer.axes import Axes, Entry, NumberedAxis, axis_for
from viewer.component_batches import NONE, points, strips
from viewer.curve import CURVE_STEP, dashes, runs
from viewer.frame import Floats, Frame
from viewer.learning import DAMPING, log_axes, symmetric
from viewer.names import channel, words
from viewer.palette import Colour, Palette
from viewer.recorder import Recorder

MAX_ROWS = 2
"""Further velocities that have a row: more of them are too small to read."""
SLICE_QUANTILES = (0.1, 0.5, 0.9)
"""Quantiles of the vectors at which the slices are taken."""
ROUNDING_STEPS = 20
"""The values of the slices are multiples of about this part of the axis, so that the legend seldom changes."""
WIDTH, HEIGHT = 1300, 800


def entities(number: int) -> tuple[list[str], list[str]]:
    """What is drawn on the axes of a row's slices, and on those of its plane."""
    slices = [
        f"learning/slices/{number}/{kind}_{k}" for kind in ("curve", "beyond") for k in range(len(SLICE_QUANTILES))
    ]
    return slices, [f"learning/slices/{number}/{name}" for name in ("vectors", "batch")]


def axes_paths(number: int) -> tuple[str, str]:
    """Where the pictures of the two plots of a row are."""
    return f"learning/slices/{number}/axes", f"learning/slices/{number}/plane"


class SlicesPage:
    """Logs below learning/slices/, where damping is learned over several velocities."""

    def __init__(self, rec: Recorder, palette: Palette) -> None:
        self._rec, self._palette = rec, palette
        self.others: tuple[str, ...] = ()
        """The further velocities that have a row; none before the first model over several."""
        self._axes_by_path: dict[str, Axes] = {}

    def log(self, frame: Frame, axes: Axes) -> None:
        """One iteration on the axes of the page Learning, at the clocks that are set."""
        model = frame.model
        if model is None or model.several is None:
            return
        if not self.others:
            self.others = model.several.others[:MAX_ROWS]
            for number in range(len(self.others)):
                self._style(number)
        for number, name in enumerate(self.others):
            self._slices(number, name, model, model.several, axes)
            self._plane(number, name, model.several, frame, axes)

    def _slices(self, number: int, name: str, model: Model, several: Several, beside: Axes) -> None:
        column = several.velocity[:, 1 + number]
        step = axis_for(float(column.min()), float(column.max()), "", ticks=ROUNDING_STEPS).step
        values = np.round(np.quantile(column, SLICE_QUANTILES) / step) * step
        entries = tuple(
            Entry("line", colour, f"{words(name)} {value:.4g}")
            for value, colour in zip(values, self._colours, strict=True)
        )
        signs = (Entry("dashes", self._palette.text, "Extrapolated"),)
        step = beside.size(CURVE_STEP)[0]
        rate: Floats = np.arange(beside.x.low, beside.x.high + step / 2.0, step, dtype=np.float64)
        said = []
        for value in values:
            velocity = several.beside(rate)
            velocity[:, 1 + number] = value
            said.append(model.over(velocity))
        largest = [float(np.abs(each.damping[~each.extrapolated]).max(initial=0.0)) for each in said]
        path = axes_paths(number)[0]
        y = self._wide(path, max(*largest, float(np.abs(model.support_damping).max())), self._rec.words.fill(DAMPING))
        axes = Axes(beside.x, y, WIDTH, HEIGHT, legend=(entries, signs), font=30)
        self._lay(path, axes, entities(number)[0])
        for k, each in enumerate(said):
            curve = np.column_stack((rate, each.damping))
            beyond = [dashes(run, axes.y.high) for run in runs(curve, each.extrapolated)]
            self._rec.log(f"learning/slices/{number}/curve_{k}", strips(runs(curve, ~each.extrapolated)))
            self._rec.log(f"learning/slices/{number}/beyond_{k}", strips(np.concatenate(beyond) if beyond else NONE))

    def _plane(self, number: int, name: str, several: Several, frame: Frame, beside: Axes) -> None:
        vectors = several.velocity[:, [0, 1 + number]]
        batch = frame.report.batch
        fresh = np.column_stack((batch.rate, np.array(batch.channels.get(name, ()), dtype=np.float64)))
        path = axes_paths(number)[1]
        y = self._wide(path, max(float(np.abs(each[:, 1]).max()) for each in (vectors, fresh)), channel(name))
        signs = (
            Entry("disc", self._palette.support, "Support vectors"),
            Entry("dots", self._palette.new, "The newest batch"),
        )
        axes = Axes(beside.x, y, WIDTH, HEIGHT, legend=(signs,), font=30)
        self._lay(path, axes, entities(number)[1])
        self._rec.log(f"learning/slices/{number}/vectors", points(vectors))
        self._rec.log(f"learning/slices/{number}/batch", points(fresh))

    def _wide(self, path: str, reach: float, label: str) -> NumberedAxis:
        """An axis that holds ±reach; it only grows."""
        known = self._axes_by_path.get(path)
        return known.y if known is not None and reach <= known.y.high else symmetric(reach, label)

    def _lay(self, path: str, axes: Axes, shown: list[str]) -> None:
        """Draws the axes anew where they have changed."""
        if self._axes_by_path.get(path) != axes:
            self._axes_by_path[path] = axes
            log_axes(self._rec, path, axes, self._palette, shown)

    @property
    def _colours(self) -> tuple[Colour, Colour, Colour]:
        return self._palette.old, self._palette.function, self._palette.before

    def _style(self, number: int) -> None:
        for k, colour in enumerate(self._colours):
            for kind, width in (("curve", 2.4), ("beyond", 1.6)):
                self._rec.strip(f"learning/slices/{number}/{kind}_{k}", colour, width, 20.0 + k)
        for name, colour, radius in (("vectors", self._palette.support, 5.0), ("batch", self._palette.new, 2.2)):
            self._rec.points(f"learning/slices/{number}/{name}", colour, radius, 10.0)


TITLES = (f"{DAMPING}, slices", "Where it was driven")
"""Titles of the two plots of a row."""
