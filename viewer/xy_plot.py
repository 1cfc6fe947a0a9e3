"""An XY plot in Rerun, which has none: axes as a picture behind a 2D view, and the data over them.

The picture is drawn once, and anew where the data outgrow it. The data keep their own units, so that pointing at a
sample shows rad/s and N m.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import rerun as rr
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator
from rerun.components import Radius

from viewer import palette
from viewer.frame import Floats
from viewer.palette import Colour, hexadecimal
from viewer.recorder import Recorder

WIDTH, HEIGHT = 1500, 1330
"""The canvas, in its own units; (0, 0) is its upper left corner."""
LEFT, RIGHT, TOP, BOTTOM = 130.0, 1460.0, 275.0, 1235.0
"""The frame on the canvas."""
SHARP = 1.6  # pixels of the picture for one unit of the canvas: stays sharp on a large screen
FONT = 22.0  # points of a picture of 15 inches: read from two metres
AIR = 1.15  # times what the axes must hold, so that a run that widens its range redraws them a few times only
STROKES: Mapping[str, tuple[tuple[tuple[float, float], ...], ...]] = {
    "s": (((-5, -5), (5, -5), (5, 5), (-5, 5), (-5, -5)),),
    "x": (((-10, -10), (10, 10)), ((-10, 10), (10, -10))),
    "D": (((0, 14), (14, 0), (0, -14), (-14, 0), (0, 14)),),
    "_": (((-10, 0), (10, 0)),),
    "|": (((0, -10), (0, 10)),),
}
"""Marks beside the disc `o`, as matplotlib names them: their lines in units of the canvas."""
Lines = Sequence[Floats] | Floats
"""Lines through (n, 2) points each, or (m, n, 2) for m lines of equal length."""


@dataclass(frozen=True, slots=True)
class Sign:
    """How samples or a curve are drawn, and what the legend calls them.

    Attributes:
        text: of the legend; what has none is not in it.
        mark: of samples, as matplotlib names it.
        line: of a curve: full, dashed, the strokes of an area, or arrows.
        size: the radius of a sample or of a line [points].
        order: what has a later one is above.
    """

    text: str
    colour: Colour | tuple[int, int, int, int]
    mark: str = ""
    line: Literal["", "-", "--", "|||", "^"] = ""
    size: float = 5.0
    order: float = 10.0

    def handle(self) -> Artist:
        """The sign in the legend."""
        colour = hexadecimal(self.colour)
        if self.line == "|||":
            return Patch(facecolor="none", edgecolor=colour, hatch="|||", linewidth=1.6, label=self.text)
        filled = self.mark in ("o", "s") and self.size < 9.0
        mark, line = ("^", "none") if self.line == "^" else (self.mark or None, self.line or "none")
        return Line2D(
            [], [], color=colour, marker=mark, linestyle=line, markersize=2.6 * self.size,
            markerfacecolor=None if filled else "none", markeredgewidth=3.0, linewidth=2.0 * self.size, label=self.text,
        )  # fmt: skip

    def style(self, rec: Recorder, path: str) -> None:
        """How what comes at `path` looks; it stays the same over all iterations."""
        points, strips = rr.Points2D.from_fields, rr.LineStrips2D.from_fields
        stroke = self.size if self.line else 2.0
        parts: list[Any] = []
        if self.line or self.mark in STROKES:
            parts.append(strips(colors=self.colour, radii=Radius.ui_points(stroke), draw_order=self.order))
        if self.mark:
            disc = self.size if self.mark == "o" else stroke
            parts.append(points(colors=self.colour, radii=Radius.ui_points(disc), draw_order=self.order))
        rec.log(path, *parts, static=True)


@dataclass(frozen=True, slots=True)
class Axes:
    """From −`x` to `x` and from −`y` to `y`, in the units that stand in the labels."""

    x: float
    y: float

    @staticmethod
    def around(x: float, y: float) -> Axes:
        """Axes with some air around −x to x and −y to y, that end at round numbers."""
        ends = (MaxNLocator(10, steps=(1, 2, 2.5, 5, 10)).tick_values(-AIR * each, AIR * each)[-1] for each in (x, y))
        return Axes(*map(float, ends))

    @property
    def scale(self) -> tuple[float, float]:
        """Canvas units per physical unit; y points down on the canvas."""
        return (RIGHT - LEFT) / (2.0 * self.x), -(BOTTOM - TOP) / (2.0 * self.y)

    def size(self, units: float) -> tuple[float, float]:
        """What spans `units` of the canvas in both directions, in physical units."""
        return units / self.scale[0], -units / self.scale[1]

    def png(self, labels: tuple[str, str], legend: Sequence[Sign]) -> bytes:
        """The picture of frame, grid, numbered ticks, labels and legend: PNG, SHARP times the canvas."""
        figure = Figure(figsize=(WIDTH / 100.0, HEIGHT / 100.0), dpi=100.0 * SHARP)
        figure.set_facecolor(hexadecimal(palette.BACKGROUND))
        box = (LEFT / WIDTH, 1.0 - BOTTOM / HEIGHT, (RIGHT - LEFT) / WIDTH, (BOTTOM - TOP) / HEIGHT)
        text, frame = hexadecimal(palette.TEXT), hexadecimal(palette.FRAME)
        plot = figure.add_axes(box, facecolor="none", xlim=(-self.x, self.x), ylim=(-self.y, self.y))
        plot.set_xlabel(labels[0], color=text, fontsize=FONT)
        # The label of y stands upright above its axis: nobody has to tilt the head.
        figure.text(0.01, 1.0 - (TOP - 24.0) / HEIGHT, labels[1], color=text, fontsize=FONT, va="bottom")
        plot.tick_params(labelsize=0.9 * FONT, labelcolor=text, color=frame, pad=8.0)
        plot.locator_params(nbins=10, steps=(1, 2, 2.5, 5, 10))
        plot.grid(color=hexadecimal(palette.GRID), linewidth=1.5)
        for line in (plot.axhline, plot.axvline):
            line(0.0, color=frame, linewidth=1.5, zorder=1.0)
        plot.spines[:].set(visible=True, color=frame, linewidth=2.0)  # whatever style another drawing has in force
        figure.legend(
            handles=[sign.handle() for sign in legend if sign.text], ncols=3 if len(legend) > 4 else 2,
            loc="upper left", fontsize=FONT, labelcolor=text, frameon=False, borderaxespad=0.2, columnspacing=1.5,
            labelspacing=0.35,
        )  # fmt: skip
        written = io.BytesIO()
        figure.savefig(written, format="png", facecolor=figure.get_facecolor(), pil_kwargs={"compress_level": 6})
        return written.getvalue()


class Plot:
    """Samples and curves on axes that only ever grow.

    Args:
        picture: the entity of the axes.
        signs: how each entity looks, in the order of the legend's columns.
        labels: of x and y, with their units.
    """

    def __init__(self, rec: Recorder, picture: str, signs: Mapping[str, Sign], labels: tuple[str, str]) -> None:
        self._rec, self._picture, self._signs, self._labels = rec, picture, signs, labels
        self._axes: Axes | None = None
        self._drawn: dict[str, bytes] = {}  # what each entity has on the screen
        for path, sign in signs.items():
            sign.style(rec, path)

    def hold(self, x: float, y: float) -> Axes:
        """Axes that hold ±x and ±y; where they grow, all that is given next is drawn anew."""
        if self._axes is None or x > self._axes.x or y > self._axes.y:
            self._axes = Axes.around(x, y)
            self._drawn.clear()
            png = self._axes.png(self._labels, list(self._signs.values()))
            self._rec.log(self._picture, rr.EncodedImage(contents=png, media_type="image/png", draw_order=-10.0))
            self._rec.log(self._picture, rr.Transform3D(scale=1.0 / SHARP))
            middle = [(LEFT + RIGHT) / 2.0, (TOP + BOTTOM) / 2.0, 0.0]
            for path in self._signs:
                self._rec.log(path, rr.Transform3D(translation=middle, scale=[*self._axes.scale, 1.0]))
        return self._axes

    def points(self, path: str, at: Floats) -> None:
        """Samples `at` (n, 2) [rad/s, N m] with their mark around them, upright on the axes; none clear the former."""
        assert self._axes is not None
        strokes = [np.array(stroke) * self._axes.size(1.0) for stroke in STROKES.get(self._signs[path].mark, ())]
        marks = [rr.LineStrips2D([point + stroke for point in at for stroke in strokes])] if strokes else []
        self._draw(path, at.tobytes(), rr.Points2D(at), *marks)

    def lines(self, path: str, lines: Lines) -> None:
        """Curves; none clear the former."""
        self._draw(path, b"".join(line.tobytes() for line in lines), rr.LineStrips2D(list(lines)))

    def _draw(self, path: str, drawn: bytes, *parts: Any) -> None:
        if self._drawn.get(path) != drawn:
            self._drawn[path] = drawn
            self._rec.log(path, *parts)
