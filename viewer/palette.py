"""The colours of the viewer.

Every colour of the axes reaches a contrast of at least 3:1 on them, and no meaning rests on colour alone: each set has
a shape, each curve a line style.
"""

from __future__ import annotations

Colour = tuple[int, int, int]


def hexadecimal(colour: tuple[int, ...]) -> str:
    """As matplotlib takes it."""
    return "#{:02x}{:02x}{:02x}".format(*colour)


def _rgb(text: str) -> Colour:
    return int(text[0:2], 16), int(text[2:4], 16), int(text[4:6], 16)


BACKGROUND, FRAME, TEXT = _rgb("0E151D"), _rgb("7C8A99"), _rgb("DCE4EC")
GRID, BAND = _rgb("25303B"), _rgb("3F6485")  # recede on purpose
# As in Fig. 5–6: old blue, new red, support green, forgotten yellow.
OLD, NEW, SUPPORT, FORGOTTEN = _rgb("4FA3FF"), _rgb("FF5B4D"), _rgb("2FD584"), _rgb("FFD23C")
DISCARDED, OUTLIER = _rgb("8E9CAB"), _rgb("F07CFF")
FUNCTION, BEFORE, TUBE = _rgb("FFFFFF"), _rgb("FFB066"), _rgb("F0781E")

# For Rerun's own plots, which follow its theme: these are read on white and on black.
GREEN, BLUE, RED, PURPLE = _rgb("0E9152"), _rgb("1668D8"), _rgb("D8261B"), _rgb("B01FC4")
AMBER, GREY, ORANGE = _rgb("AD8200"), _rgb("707C88"), _rgb("B45A00")
SERIES = (GREEN, BLUE, RED, PURPLE, AMBER, GREY, ORANGE)
