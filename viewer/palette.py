"""Colours for dark and light axes, chosen together with the signs in `learning`.

Every colour reaches a contrast of at least 3:1 on its own axes (tests/viewer), and no meaning rests on colour alone:
each set has a shape, each curve a line style.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Colour = tuple[int, int, int]
Theme = Literal["dark", "light"]


def hexadecimal(colour: Colour) -> str:
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


DARK = Palette(
    background=_rgb("0E151D"),
    grid=_rgb("25303B"),
    band=_rgb("3F6485"),
    frame=_rgb("7C8A99"),
    text=_rgb("DCE4EC"),
    old=_rgb("4FA3FF"),
    new=_rgb("FF5B4D"),
    support=_rgb("2FD584"),
    forgotten=_rgb("FFD23C"),
    discarded=_rgb("8E9CAB"),
    outlier=_rgb("F07CFF"),
    function=_rgb("FFFFFF"),
    before=_rgb("FFB066"),
    tube=_rgb("F0781E"),
)

LIGHT = Palette(
    background=_rgb("FFFFFF"),
    grid=_rgb("E3E8ED"),
    band=_rgb("A9C6E2"),
    frame=_rgb("5D6975"),
    text=_rgb("1B242D"),
    old=_rgb("1668D8"),
    new=_rgb("D8261B"),
    support=_rgb("0E9152"),
    forgotten=_rgb("AD8200"),
    discarded=_rgb("707C88"),
    outlier=_rgb("B01FC4"),
    function=_rgb("0B1016"),
    before=_rgb("B45A00"),
    tube=_rgb("E2660A"),
)

PALETTES: dict[Theme, Palette] = {"dark": DARK, "light": LIGHT}
