"""Draws in units of a plot's canvas, and knows the sign of every set and curve (`marks` draws the same in Rerun)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from PIL import ImageDraw, ImageFont

from viewer.palette import Colour, Palette

Mark = Literal[
    "dots",
    "speck",
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


class Painter:
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
            case "speck":
                self.disc(x, y, 3.5 * unit, colour)
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
