"""Colours for dark and light axes, chosen together with the signs in `learning`.

Every colour reaches a contrast of at least 3:1 on its own axes (tests/viewer), and no meaning rests on colour alone:
each set has a shape, each curve a line style.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Colour = tuple[int, int, int]
Theme = Literal["dark", "light"]


def hexadecimal(colour: tuple[int, ...]) -> str:
    """As matplotlib takes it."""
    return "#{:02x}{:02x}{:02x}".format(*colour)


def _rgb(text: str) -> Colour:
    return int(text[0:2], 16), int(text[2:4], 16), int(text[4:6], 16)


@dataclass(frozen=True, slots=True)
class Palette:
    """One theme's colours. As in Fig. 5–6: old blue, new red, support green, forgotten yellow."""

    background: Colour
    grid: Colour  # recedes on purpose
    band: Colour  # a filled area, recedes on purpose
    frame: Colour
    text: Colour
    old: Colour
    new: Colour
    support: Colour
    forgotten: Colour
    discarded: Colour
    outlier: Colour
    function: Colour
    before: Colour
    tube: Colour


_COLOURS = {
    "background": ("0E151D", "FFFFFF"),
    "grid": ("25303B", "E3E8ED"),
    "band": ("3F6485", "A9C6E2"),
    "frame": ("7C8A99", "5D6975"),
    "text": ("DCE4EC", "1B242D"),
    "old": ("4FA3FF", "1668D8"),
    "new": ("FF5B4D", "D8261B"),
    "support": ("2FD584", "0E9152"),
    "forgotten": ("FFD23C", "AD8200"),
    "discarded": ("8E9CAB", "707C88"),
    "outlier": ("F07CFF", "B01FC4"),
    "function": ("FFFFFF", "0B1016"),
    "before": ("FFB066", "B45A00"),
    "tube": ("F0781E", "E2660A"),
}
"""On dark and on light axes."""
DARK, LIGHT = (Palette(**{name: _rgb(each[number]) for name, each in _COLOURS.items()}) for number in (0, 1))
SERIES = (LIGHT.support, LIGHT.old, LIGHT.new, LIGHT.outlier, LIGHT.forgotten, LIGHT.discarded, LIGHT.before)
"""For Rerun's own plots, which follow its theme: these colours are read on white and on black."""
PALETTES: dict[Theme, Palette] = {"dark": DARK, "light": LIGHT}
