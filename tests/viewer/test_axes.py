"""Axes that follow the vehicle, colours that are seen on their ground."""

from __future__ import annotations

import io
from dataclasses import fields
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image, ImageFont

from incsvr.plant.axes import AXES
from incsvr.plant.words import words_of
from viewer.axes import Axes, NumberedAxis, axis_for, even_axis
from viewer.learning import DAMPING, RATE
from viewer.painter import SHARP
from viewer.palette import DARK, LIGHT, Colour, Palette

NATIVE_GROUNDS = [(13, 13, 13), (255, 255, 255)]  # of Rerun's own plots, in its two themes


@given(st.floats(1e-6, 1e6), st.integers(3, 12))
def test_an_axis_holds_its_range_with_few_round_ticks(reach: float, ticks: int) -> None:
    axis = axis_for(-reach, reach, "Anything [-]", ticks=ticks)
    assert axis.low <= -0.999 * reach < 0.999 * reach <= axis.high
    assert 2 <= len(axis.ticks) <= ticks + 3
    assert axis.ticks[0] == pytest.approx(axis.low)
    assert axis.ticks[-1] == pytest.approx(axis.high)


@given(st.floats(1e-6, 1e6))
def test_two_even_axes_share_one_grid(reach: float) -> None:
    axis = even_axis(reach, "Anything [-]")
    assert len(axis.ticks) == 5
    assert axis.high >= 0.999 * reach
    assert len({axis.text(tick) for tick in axis.ticks}) == 5


@pytest.mark.parametrize(("rate", "damping"), [(0.25, 100.0), (1.8, 6.0), (0.25, 12345.0), (0.002, 0.004)])
def test_labels_never_overlap(rate: float, damping: float) -> None:
    x, y = (axis_for(-1.15 * reach, 1.15 * reach, "", ticks=10) for reach in (rate, damping))
    axes = Axes(x, y, 1500, 1330, font=32)
    font = ImageFont.load_default(32)
    ends = [
        (axes.canvas(tick, 0.0)[0] - font.getlength(x.text(tick)) / 2, font.getlength(x.text(tick))) for tick in x.ticks
    ]
    for (left, width), (following, _) in pairwise(ends):
        assert left + width + 8 < following
    for tick in y.ticks:
        assert font.getlength(y.text(tick)) < axes.left - 0.4 * axes.font


def test_the_canvas_and_physical_units_agree() -> None:
    axes = Axes(axis_for(-0.3, 0.3, "x"), axis_for(-120.0, 120.0, "y"), 1500, 1330)
    assert axes.canvas(axes.x.low, axes.y.low) == pytest.approx((axes.left, axes.bottom))
    assert axes.canvas(axes.x.high, axes.y.high) == pytest.approx((axes.right, axes.top))


@pytest.mark.parametrize("palette", [DARK, LIGHT])
def test_the_picture_has_the_colours_it_was_told(palette: Palette) -> None:
    axes = Axes(NumberedAxis(-1.0, 1.0, 0.5, "x"), NumberedAxis(-1.0, 1.0, 0.5, "y"), 400, 300)
    picture = Image.open(io.BytesIO(axes.png(palette))).convert("RGB")
    assert picture.size == (round(400 * SHARP), round(300 * SHARP))
    assert picture.getpixel((2, 2)) == palette.background
    assert palette.frame in {colour for _, colour in picture.getcolors(1 << 20) or ()}


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
