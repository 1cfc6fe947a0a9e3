"""A plate: the axes of an XY plot as a picture, and the way from physical units to its canvas.

Rerun has no XY view. A plate is drawn once, is put behind a 2D view, and the data are drawn over it in their own units,
so that pointing at a sample shows rad/s and N m.
"""

from __future__ import annotations

import io
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil, floor, log10
from typing import Literal

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from viewer.palette import Colour, Palette

Mark = Literal[
    "dots",
    "disc",
    "halo",
    "square",
    "cross",
    "dash",
    "bar",
    "diamond",
    "line",
    "tube",
    "band",
    "dashes",
    "arrow",
    "frame",
]
SHARP = 1.6  # pixels of the picture for one unit of the canvas: stays sharp on a large screen
RAMP = 200  # shades from the background to the text; the colours of the legend follow


@dataclass(frozen=True, slots=True)
class Axis:
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


def axis_for(low: float, high: float, label: str, *, ticks: int = 8) -> Axis:
    """The axis whose ends are multiples of a round step (1, 2, 2.5 or 5 times a power of ten) around [low, high]."""
    if not high > low:
        low, high = low - 0.5, high + 0.5
    raw = (high - low) / ticks
    power = 10.0 ** floor(log10(raw))
    step = next(factor * power for factor in (1.0, 2.0, 2.5, 5.0, 10.0) if factor * power >= raw * 0.999)
    return Axis(floor(low / step + 1e-6) * step, ceil(high / step - 1e-6) * step, step, label)


def even_axis(reach: float, label: str) -> Axis:
    """From −2 to 2 steps around zero, so that two such axes share one grid."""
    power = 10.0 ** floor(log10(reach / 2.0)) if reach > 0.0 else 1.0
    step = next(
        k * power for k in (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0) if 2.0 * k * power >= reach * 0.999
    )
    return Axis(-2.0 * step, 2.0 * step, step, label)


@dataclass(frozen=True, slots=True)
class Entry:
    """One word of the legend."""

    mark: Mark
    colour: Colour
    text: str


@dataclass(frozen=True, slots=True)
class Plate:
    """Axes on a canvas of `width` × `height` units; (0, 0) is the canvas' upper left corner."""

    x: Axis
    y: Axis
    width: int
    height: int
    legend: tuple[tuple[Entry, ...], ...] = ()  # rows
    font: int = 30
    y_right: Axis | None = None  # a second quantity over the same x

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
        pen = _Pen(ImageDraw.Draw(picture), palette, self.font)
        for tick in self.x.ticks:
            at, _ = self.canvas(tick, 0.0)
            pen.line([(at, self.top), (at, self.bottom)], palette.frame if tick == 0.0 else palette.grid, 1.5)
            pen.text((at, self.bottom + 0.55 * self.font), self.x.text(tick), "mt")
        for tick in self.y.ticks:
            _, at = self.canvas(0.0, tick)
            pen.line([(self.left, at), (self.right, at)], palette.frame if tick == 0.0 else palette.grid, 1.5)
            pen.text((self.left - 0.4 * self.font, at), self.y.text(tick), "rm")
        if self.y_right is not None:
            beside = replace(self, y=self.y_right)
            for tick in self.y_right.ticks:
                pen.text((self.right + 0.4 * self.font, beside.canvas(0.0, tick)[1]), self.y_right.text(tick), "lm")
            pen.text((self.width - 0.4 * self.font, self.top - 0.85 * self.font), self.y_right.label, "rs")
        corners = [(self.left, self.top), (self.right, self.top), (self.right, self.bottom), (self.left, self.bottom)]
        pen.line([*corners, corners[0]], palette.frame, 2.0)
        pen.text(((self.left + self.right) / 2, self.height - 0.35 * self.font), self.x.label, "ms")
        # The label of y stands upright above its axis: nobody has to tilt the head.
        pen.text((0.4 * self.font, self.top - 0.85 * self.font), self.y.label, "ls")
        _legend(pen, self)
        picture.putpalette(pen.colours())
        written = io.BytesIO()
        picture.save(written, "PNG", compress_level=6, compress_type=zlib.Z_RLE)
        return written.getvalue()


class _Pen:
    """Draws in units of the canvas."""

    def __init__(self, draw: ImageDraw.ImageDraw, palette: Palette, font: int) -> None:
        self.draw, self.palette, self.size = draw, palette, font
        self.font = ImageFont.load_default(font * SHARP)
        self._inks: dict[Colour, int] = {palette.text: RAMP - 1}

    def ink(self, colour: Colour) -> int:
        """The number of a colour."""
        return self._inks.setdefault(colour, RAMP - 1 + len(self._inks))

    def colours(self) -> bytes:
        """Red, green and blue of every number."""
        share = np.linspace(0.0, 1.0, RAMP)[:, None]
        ramp = (1.0 - share) * self.palette.background + share * self.palette.text
        return bytes(ramp.round().astype(np.uint8)) + bytes(part for ink in list(self._inks)[1:] for part in ink)

    def line(self, points: Sequence[tuple[float, float]], colour: Colour, width: float) -> None:
        self.draw.line(
            [(x * SHARP, y * SHARP) for x, y in points], self.ink(colour), round(width * SHARP), joint="curve"
        )

    def box(self, x: float, y: float, half_x: float, half_y: float, colour: Colour) -> None:
        self.draw.rectangle(
            [(c * SHARP) for c in (x - half_x, y - half_y, x + half_x, y + half_y)], fill=self.ink(colour)
        )

    def disc(self, x: float, y: float, radius: float, colour: Colour, *, ring: float = 0.0) -> None:
        corners = [(c * SHARP) for c in (x - radius, y - radius, x + radius, y + radius)]
        if ring:
            self.draw.ellipse(corners, outline=self.ink(colour), width=round(ring * SHARP))
        else:
            self.draw.ellipse(corners, fill=self.ink(colour))

    def text(self, at: tuple[float, float], text: str, anchor: str) -> None:
        self.draw.text((at[0] * SHARP, at[1] * SHARP), text, RAMP - 1, self.font, anchor)

    def mark(self, mark: Mark, x: float, y: float, colour: Colour) -> None:
        """The sign of a set or curve, as the data show it (`marks`)."""
        unit = self.size / 30
        match mark:
            case "disc":
                self.disc(x, y, 7 * unit, colour)
            case "square":
                self.box(x, y, 7 * unit, 7 * unit, colour)
            case "halo":
                self.disc(x, y, 12 * unit, colour, ring=3.4 * unit)
            case "cross":
                for sign in (-1, 1):
                    self.line(
                        [(x - 9 * unit, y - sign * 9 * unit), (x + 9 * unit, y + sign * 9 * unit)], colour, 4 * unit
                    )
            case "dash":
                self.box(x, y, 8 * unit, 2 * unit, colour)
            case "bar":
                self.box(x, y, 2 * unit, 8 * unit, colour)
            case "diamond":
                r = 12 * unit
                self.line([(x, y - r), (x + r, y), (x, y + r), (x - r, y), (x, y - r), (x + r, y)], colour, 3.4 * unit)
            case "line":
                self.line([(x - 26 * unit, y), (x + 26 * unit, y)], colour, 5 * unit)
            case "tube":
                for side in (-5, 5):
                    self.line([(x - 26 * unit, y + side * unit), (x + 26 * unit, y + side * unit)], colour, 2 * unit)
            case "band":
                for at in range(-26, 27, 6):
                    self.line([(x + at * unit, y - 10 * unit), (x + at * unit, y + 10 * unit)], colour, 2 * unit)
                for side in (-10, 10):
                    self.line([(x - 26 * unit, y + side * unit), (x + 26 * unit, y + side * unit)], colour, 2 * unit)
            case "frame":
                r = 8 * unit
                self.line(
                    [(x - r, y - r), (x + r, y - r), (x + r, y + r), (x - r, y + r), (x - r, y - r)], colour, 3 * unit
                )
            case "arrow":
                self.line(
                    [(x - 10 * unit, y + 7 * unit), (x, y - 7 * unit), (x + 10 * unit, y + 7 * unit)],
                    colour,
                    3.4 * unit,
                )
            case "dots":
                for at in range(-24, 25, 12):
                    self.line([(x + (at - 2.5) * unit, y), (x + (at + 2.5) * unit, y)], colour, 5 * unit)
            case "dashes":
                for at in (-18, 0, 18):
                    self.line([(x + (at - 6) * unit, y), (x + (at + 6) * unit, y)], colour, 5 * unit)


def _legend(pen: _Pen, plate: Plate) -> None:
    """Rows of signs and words above the plot, in columns so that the eye can run down."""
    unit = plate.font / 30
    columns = max((len(row) for row in plate.legend), default=1)
    width = (plate.right - 0.4 * plate.font) / columns
    for number, row in enumerate(plate.legend):
        y = (0.95 + 1.45 * number) * plate.font
        for column, entry in enumerate(row):
            x = 0.4 * plate.font + column * width
            pen.mark(entry.mark, x + 28 * unit, y, entry.colour)
            pen.text((x + 66 * unit, y), entry.text, "lm")
