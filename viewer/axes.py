"""The axes of an XY plot as a picture, and the way from physical units to its canvas.

Rerun has no XY view. These axes are drawn once, are put behind a 2D view, and the data are drawn over them in their own
units, so that pointing at a sample shows rad/s and N m.
"""

from __future__ import annotations

import io
import zlib
from dataclasses import dataclass, replace
from math import ceil, floor, log10

from PIL import Image, ImageDraw

from viewer.painter import SHARP, Mark, Painter
from viewer.palette import Colour, Palette


@dataclass(frozen=True, slots=True)
class NumberedAxis:
    """A numbered axis: from `low` to `high` with a tick each `step`, in the unit that stands in `label`."""

    low: float
    high: float
    step: float
    label: str

    @property
    def ticks(self) -> list[float]:
        first, last = ceil(self.low / self.step - 1e-6), floor(self.high / self.step + 1e-6)
        return [k * self.step for k in range(first, last + 1)]

    def text(self, value: float) -> str:
        digits = next((d for d in range(9) if abs(round(self.step, d) - self.step) < 1e-6 * self.step), 9)
        return f"{value:.{digits}f}" if abs(value) > self.step * 1e-6 else "0"


def axis_for(low: float, high: float, label: str, *, ticks: int = 8) -> NumberedAxis:
    """The axis whose ends are multiples of a round step (1, 2, 2.5 or 5 times a power of ten) around [low, high]."""
    if not high > low:
        low, high = low - 0.5, high + 0.5
    raw = (high - low) / ticks
    power = 10.0 ** floor(log10(raw))
    step = next(factor * power for factor in (1.0, 2.0, 2.5, 5.0, 10.0) if factor * power >= raw * 0.999)
    return NumberedAxis(floor(low / step + 1e-6) * step, ceil(high / step - 1e-6) * step, step, label)


def even_axis(reach: float, label: str) -> NumberedAxis:
    """From −2 to 2 steps around zero, so that two such axes share one grid."""
    power = 10.0 ** floor(log10(reach / 2.0)) if reach > 0.0 else 1.0
    step = next(
        k * power for k in (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0) if 2.0 * k * power >= reach * 0.999
    )
    return NumberedAxis(-2.0 * step, 2.0 * step, step, label)


@dataclass(frozen=True, slots=True)
class Entry:
    """One word of the legend."""

    mark: Mark
    colour: Colour
    text: str


@dataclass(frozen=True, slots=True)
class Axes:
    """Axes on a canvas of `width` × `height` units; (0, 0) is the canvas' upper left corner."""

    x: NumberedAxis
    y: NumberedAxis
    width: int
    height: int
    legend: tuple[tuple[Entry, ...], ...] = ()  # rows
    font: int = 30
    y_right: NumberedAxis | None = None  # a second quantity over the same x

    @property
    def left(self) -> float:
        return 4.4 * self.font

    @property
    def right(self) -> float:
        return self.width - (1.3 if self.y_right is None else 4.4) * self.font

    @property
    def top(self) -> float:
        return (2.2 + 1.45 * len(self.legend)) * self.font

    @property
    def bottom(self) -> float:
        return self.height - 3.1 * self.font

    @property
    def scale(self) -> tuple[float, float]:
        """Canvas units per physical unit; y points down on the canvas."""
        return (
            (self.right - self.left) / (self.x.high - self.x.low),
            -(self.bottom - self.top) / (self.y.high - self.y.low),
        )

    @property
    def translation(self) -> tuple[float, float]:
        """Where the physical (0, 0) lies on the canvas."""
        sx, sy = self.scale
        return self.left - self.x.low * sx, self.bottom - self.y.low * sy

    def size(self, units: float) -> tuple[float, float]:
        """What spans `units` of the canvas in both directions, in physical units."""
        sx, sy = self.scale
        return units / abs(sx), units / abs(sy)

    def canvas(self, x: float, y: float) -> tuple[float, float]:
        (sx, sy), (tx, ty) = self.scale, self.translation
        return tx + sx * x, ty + sy * y

    def png(self, palette: Palette) -> bytes:
        """The picture, PNG, SHARP times the canvas.

        One byte a pixel, its shades numbered from the background to the text: a tenth of the time of full colour, and
        drawn while a vehicle waits for the next iteration.
        """
        picture = Image.new("L", (round(self.width * SHARP), round(self.height * SHARP)), 0)
        painter = Painter(ImageDraw.Draw(picture), palette, self.font)
        for tick in self.x.ticks:
            at, _ = self.canvas(tick, 0.0)
            painter.line([(at, self.top), (at, self.bottom)], palette.frame if tick == 0.0 else palette.grid, 1.5)
            painter.text((at, self.bottom + 0.55 * self.font), self.x.text(tick), "mt")
        for tick in self.y.ticks:
            _, at = self.canvas(0.0, tick)
            painter.line([(self.left, at), (self.right, at)], palette.frame if tick == 0.0 else palette.grid, 1.5)
            painter.text((self.left - 0.4 * self.font, at), self.y.text(tick), "rm")
        if self.y_right is not None:
            beside = replace(self, y=self.y_right)
            for tick in self.y_right.ticks:
                painter.text((self.right + 0.4 * self.font, beside.canvas(0.0, tick)[1]), self.y_right.text(tick), "lm")
            painter.text((self.width - 0.4 * self.font, self.top - 0.85 * self.font), self.y_right.label, "rs")
        corners = [(self.left, self.top), (self.right, self.top), (self.right, self.bottom), (self.left, self.bottom)]
        painter.line([*corners, corners[0]], palette.frame, 2.0)
        painter.text(((self.left + self.right) / 2, self.height - 0.35 * self.font), self.x.label, "ms")
        # The label of y stands upright above its axis: nobody has to tilt the head.
        painter.text((0.4 * self.font, self.top - 0.85 * self.font), self.y.label, "ls")
        _legend(painter, self)
        picture.putpalette(painter.colours())
        written = io.BytesIO()
        picture.save(written, "PNG", compress_level=6, compress_type=zlib.Z_RLE)
        return written.getvalue()


def _legend(painter: Painter, axes: Axes) -> None:
    """Rows of signs and words above the plot, in columns so that the eye can run down."""
    unit = axes.font / 30
    columns = max((len(row) for row in axes.legend), default=1)
    width = (axes.right - 0.4 * axes.font) / columns
    for number, row in enumerate(axes.legend):
        y = (0.95 + 1.45 * number) * axes.font
        for column, entry in enumerate(row):
            x = 0.4 * axes.font + column * width
            painter.mark(entry.mark, x + 28 * unit, y, entry.colour)
            painter.text((x + 66 * unit, y), entry.text, "lm")
