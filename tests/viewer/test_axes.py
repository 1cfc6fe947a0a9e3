"""Axes that follow the vehicle, colours that are seen on their ground."""

from __future__ import annotations

import io
from dataclasses import fields

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from incsvr.plant.axes import AXES
from incsvr.plant.words import words_of
from viewer.axes import BOTTOM, HEIGHT, LEFT, RIGHT, SHARP, TOP, WIDTH, Axes, Sign
from viewer.learning import DAMPING, RATE
from viewer.palette import DARK, LIGHT, Colour, Palette

NATIVE_GROUNDS = [(13, 13, 13), (255, 255, 255)]  # of Rerun's own plots, in its two themes


@given(st.floats(1e-6, 1e6), st.floats(1e-6, 1e6))
def test_axes_hold_their_range_and_little_more(rate: float, damping: float) -> None:
    axes = Axes.around(rate, damping, ("", ""))
    for end, reach in ((axes.x, rate), (axes.y, damping)):
        assert 1.1 * reach <= end <= 1.7 * reach


def test_the_canvas_and_physical_units_agree() -> None:
    axes = Axes(0.3, 120.0)
    (x, y), (wide, high) = axes.scale, axes.size(1.0)
    assert (2.0 * axes.x * x, -2.0 * axes.y * y) == pytest.approx((RIGHT - LEFT, BOTTOM - TOP))
    assert (wide * x, high * y) == pytest.approx((1.0, -1.0))


@pytest.mark.parametrize("palette", [DARK, LIGHT])
def test_the_frame_is_where_the_data_are_put(palette: Palette) -> None:
    """The picture's own frame and the way of the data onto the canvas agree to a pixel."""
    legend = [Sign("One", palette.old, "o"), Sign("Other", palette.new, line="--")]
    picture = Image.open(io.BytesIO(Axes(0.25, 100.0, ("x", "y")).png(palette, legend))).convert("RGB")
    assert picture.size == (round(WIDTH * SHARP), round(HEIGHT * SHARP))
    assert picture.getpixel((2, picture.height - 2)) == palette.background
    for x, y in ((LEFT, 0.3 * TOP + 0.7 * BOTTOM), (RIGHT, 600.0), (700.0, TOP), (700.0, BOTTOM)):
        assert near(picture.getpixel((round(x * SHARP), round(y * SHARP))), palette.frame)
    colours = {colour for _, colour in picture.getcolors(1 << 20) or ()}
    assert {palette.old, palette.new} <= colours


def near(one: object, other: Colour) -> bool:
    assert isinstance(one, tuple)
    return all(abs(a - b) <= 12 for a, b in zip(one, other, strict=True))


def luminance(colour: Colour) -> float:
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in (part / 255.0 for part in colour)]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one: Colour, other: Colour) -> float:
    bright, dark = sorted((luminance(one), luminance(other)), reverse=True)
    return (bright + 0.05) / (dark + 0.05)


@pytest.mark.parametrize("palette", [DARK, LIGHT])
def test_every_sign_is_seen_on_its_plate(palette: Palette) -> None:
    for field in fields(palette):
        if field.name not in ("background", "grid", "band"):
            assert contrast(getattr(palette, field.name), palette.background) >= 3.0, field.name
    assert contrast(palette.text, palette.background) >= 7.0


@pytest.mark.parametrize("ground", NATIVE_GROUNDS)
def test_the_native_plots_are_read_in_both_themes(ground: Colour) -> None:
    for name in ("old", "new", "support", "forgotten", "discarded", "outlier", "before"):
        assert contrast(getattr(LIGHT, name), ground) >= 3.0, name


def test_labels_are_in_the_words_of_the_vehicles_axis() -> None:
    labels = {name: [words_of(axis).fill(each) for each in (RATE, DAMPING)] for name, axis in AXES.items()}
    assert labels["yaw"] == ["Yaw rate [rad/s]", "Damping moment [N m]"]
    assert labels["roll"] == ["Roll rate [rad/s]", "Damping moment [N m]"]
    assert labels["surge"] == ["Surge velocity [m/s]", "Damping force [N]"]
