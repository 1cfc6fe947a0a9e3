"""Axes that follow the vehicle, drawn where the data are put."""

from __future__ import annotations

import io

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from viewer import palette
from viewer.palette import Colour
from viewer.xy_plot import BOTTOM, HEIGHT, LEFT, RIGHT, SHARP, TOP, WIDTH, Axes, Sign


@given(st.floats(1e-6, 1e6), st.floats(1e-6, 1e6))
def test_axes_hold_their_range_and_little_more(rate: float, damping: float) -> None:
    axes = Axes.around(rate, damping)
    for end, reach in ((axes.x, rate), (axes.y, damping)):
        assert 1.1 * reach <= end <= 1.7 * reach


def test_the_canvas_and_physical_units_agree() -> None:
    axes = Axes(0.3, 120.0)
    (x, y), (wide, high) = axes.scale, axes.size(1.0)
    assert (2.0 * axes.x * x, -2.0 * axes.y * y) == pytest.approx((RIGHT - LEFT, BOTTOM - TOP))
    assert (wide * x, high * y) == pytest.approx((1.0, -1.0))


def test_the_frame_is_where_the_data_are_put() -> None:
    """The picture's own frame and the way of the data onto the canvas agree to a pixel."""
    legend = [Sign("One", palette.OLD, "o"), Sign("Other", palette.NEW, line="--")]
    picture = Image.open(io.BytesIO(Axes(0.25, 100.0).png(("x", "y"), legend))).convert("RGB")
    assert picture.size == (round(WIDTH * SHARP), round(HEIGHT * SHARP))
    assert picture.getpixel((2, picture.height - 2)) == palette.BACKGROUND
    for x, y in ((LEFT, 0.3 * TOP + 0.7 * BOTTOM), (RIGHT, 600.0), (700.0, TOP), (700.0, BOTTOM)):
        assert near(picture.getpixel((round(x * SHARP), round(y * SHARP))), palette.FRAME)
    colours = {colour for _, colour in picture.getcolors(1 << 20) or ()}
    assert {palette.OLD, palette.NEW} <= colours


def near(one: object, other: Colour) -> bool:
    assert isinstance(one, tuple)
    return all(abs(a - b) <= 12 for a, b in zip(one, other, strict=True))


@pytest.mark.parametrize("name", ["OLD", "NEW", "SUPPORT", "FORGOTTEN", "DISCARDED", "OUTLIER", "BEFORE", "TUBE"])
def test_each_colour_stands_out_from_the_background(name: str) -> None:
    assert contrast(getattr(palette, name), palette.BACKGROUND) > 3.0


def test_series_are_read_in_either_theme_of_rerun() -> None:
    for colour in palette.SERIES:
        assert min(contrast(colour, back) for back in ((255, 255, 255), (13, 16, 17))) > 3.0


def contrast(one: Colour, other: Colour) -> float:
    """WCAG 2.1's ratio."""

    def light(colour: Colour) -> float:
        parts = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in (each / 255 for each in colour)]
        return 0.2126 * parts[0] + 0.7152 * parts[1] + 0.0722 * parts[2] + 0.05

    return max(light(one), light(other)) / min(light(one), light(other))
