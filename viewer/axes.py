"""The axes of an XY plot as a picture, and the way from physical units to its canvas.

Rerun has no XY view. These axes are drawn once, are put behind a 2D view, and the data are drawn over them in their own
units, so that pointing at a sample shows rad/s and N m.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import rerun as rr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from rerun.components import Radius

from viewer.frame import Floats
from viewer.palette import Colour, Palette, hexadecimal
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


@dataclass(frozen=True, slots=True)
class Sign:
    """How samples or a curve are drawn, and what the legend calls them: matplotlib's marker, line style and width."""

    text: str
    colour: Colour
    mark: str = ""
    line: Literal["", "-", "--"] = ""
    size: float = 5.0

    def handle(self) -> Line2D:
        """The sign in the legend."""
        filled = self.mark in ("o", "s") and self.size < 9.0
        return Line2D(
            [], [], color=hexadecimal(self.colour), marker=self.mark or None, linestyle=self.line or "none",
            markersize=2.6 * self.size, markerfacecolor=None if filled else "none", markeredgewidth=3.0,
            linewidth=self.size, label=self.text,
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Axes:
    """From −`x` to `x` and from −`y` to `y`, in the units that stand in the labels."""

    x: float
    y: float
    labels: tuple[str, str] = ("", "")

    @staticmethod
    def around(x: float, y: float, labels: tuple[str, str]) -> Axes:
        """Axes with some air around −x to x and −y to y, that end at round numbers."""
        ends = (MaxNLocator(10, steps=(1, 2, 2.5, 5, 10)).tick_values(-AIR * each, AIR * each)[-1] for each in (x, y))
        high_x, high_y = map(float, ends)
        return Axes(high_x, high_y, labels)

    @property
    def scale(self) -> tuple[float, float]:
        """Canvas units per physical unit; y points down on the canvas."""
        return (RIGHT - LEFT) / (2.0 * self.x), -(BOTTOM - TOP) / (2.0 * self.y)

    def size(self, units: float) -> tuple[float, float]:
        """What spans `units` of the canvas in both directions, in physical units."""
        return units / self.scale[0], -units / self.scale[1]

    def log(self, rec: Recorder, path: str, palette: Palette, legend: list[Sign], entities: list[str]) -> None:
        """The picture at `path`, and for each of `entities` the way from physical units onto it."""
        rec.log(path, rr.EncodedImage(contents=self.png(palette, legend), media_type="image/png", draw_order=-10.0))
        rec.log(path, rr.Transform3D(scale=1.0 / SHARP))
        middle = [(LEFT + RIGHT) / 2.0, (TOP + BOTTOM) / 2.0, 0.0]
        for entity in entities:
            rec.log(entity, rr.Transform3D(translation=middle, scale=[*self.scale, 1.0]))

    def png(self, palette: Palette, legend: list[Sign]) -> bytes:
        """The picture, PNG, SHARP times the canvas."""
        figure = Figure(figsize=(WIDTH / 100.0, HEIGHT / 100.0), dpi=100.0 * SHARP)
        figure.set_facecolor(hexadecimal(palette.background))
        box = (LEFT / WIDTH, 1.0 - BOTTOM / HEIGHT, (RIGHT - LEFT) / WIDTH, (BOTTOM - TOP) / HEIGHT)
        text, frame = hexadecimal(palette.text), hexadecimal(palette.frame)
        plot = figure.add_axes(box, facecolor="none", xlim=(-self.x, self.x), ylim=(-self.y, self.y))
        plot.set_xlabel(self.labels[0], color=text, fontsize=FONT)
        # The label of y stands upright above its axis: nobody has to tilt the head.
        figure.text(0.01, 1.0 - (TOP - 24.0) / HEIGHT, self.labels[1], color=text, fontsize=FONT, va="bottom")
        plot.tick_params(labelsize=0.9 * FONT, labelcolor=text, color=frame, pad=8.0)
        plot.locator_params(nbins=10, steps=(1, 2, 2.5, 5, 10))
        plot.grid(color=hexadecimal(palette.grid), linewidth=1.5)
        for line in (plot.axhline, plot.axvline):
            line(0.0, color=frame, linewidth=1.5, zorder=1.0)
        plot.spines[:].set(visible=True, color=frame, linewidth=2.0)  # whatever style another drawing has in force
        figure.legend(
            handles=[sign.handle() for sign in legend], ncols=3 if len(legend) > 4 else 2, loc="upper left",
            fontsize=FONT, labelcolor=text, frameon=False, borderaxespad=0.2, columnspacing=1.5, labelspacing=0.35,
        )  # fmt: skip
        written = io.BytesIO()
        figure.savefig(written, format="png", facecolor=figure.get_facecolor(), pil_kwargs={"compress_level": 6})
        return written.getvalue()


def style(rec: Recorder, path: str, sign: Sign, order: float) -> None:
    """How the samples at `path` look; they stay the same over all iterations. A later `order` is above."""
    radius = sign.size if sign.mark == "o" else 2.0
    parts: list[Any] = [
        rr.Points2D.from_fields(colors=sign.colour, radii=Radius.ui_points(radius), draw_order=order),
    ]
    if sign.mark in STROKES:
        parts.append(rr.LineStrips2D.from_fields(colors=sign.colour, radii=Radius.ui_points(2.0), draw_order=order))
    rec.log(path, *parts, static=True)


def place(rec: Recorder, path: str, sign: Sign, at: Floats, axes: Axes) -> None:
    """Samples `at` (n, 2) [rad/s, N m] with their mark around them, upright on the axes; none clear what was there."""
    parts: list[Any] = [rr.Points2D(at)]
    if sign.mark in STROKES:
        strokes = [np.array(stroke) * axes.size(1.0) for stroke in STROKES[sign.mark]]
        parts.append(rr.LineStrips2D([point + stroke for point in at for stroke in strokes]))
    rec.log(path, *parts)
