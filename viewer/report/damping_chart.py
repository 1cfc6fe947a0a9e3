"""The damping curve beside the samples that it was learned from, over the rates that were driven."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from incsvr.numerics import Array
from incsvr.plant.axes import YAW, Axis
from incsvr.plant.words import words_of
from viewer.report.drawing import MEASURED, binned, dots, driven, edges, svg

BAND_SHARE = 0.9
"""Part of the samples of a bin that the band around them holds."""


@dataclass(frozen=True, slots=True)
class Curve:
    """A learned damping.

    Attributes:
        label: what it is called.
        rate: (n,) increasing rates [rad/s].
        damping: (n,) d(r) [N m].
        colour, style: of its line.
        doubt: (n,) half of its interval of 95 % [N m]; None where it has none.
    """

    label: str
    rate: Array
    damping: Array
    colour: str
    style: str
    doubt: Array | None = None


def damping_chart(curves: Sequence[Curve], rate: Array, damping: Array, axis: Axis = YAW) -> str:
    """Curves over (m,) samples of rate [rad/s] and damping [N m], where there are samples."""
    return svg(lambda figure: draw_damping(figure, curves, rate, damping, axis), 4.7, 3.8)


def draw_damping(figure: Figure, curves: Sequence[Curve], rate: Array, damping: Array, axis: Axis = YAW) -> None:
    """Draws the damping on a figure."""
    words = words_of(axis)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(5, 1))
    dots(above, rate, damping, color="#5b6773", markersize=2.5, alpha=0.45, label="samples", zorder=3)
    centre, low, _, high = binned(rate, damping, edges(rate), BAND_SHARE)
    above.fill_between(centre, low, high, color="#9aa5b1", alpha=0.22, linewidth=0, label="90 % of them")
    for curve in curves:
        here = driven(curve.rate, rate)
        shown = np.where(here, curve.damping, np.nan)
        if curve.doubt is not None:
            above.fill_between(
                curve.rate, shown - curve.doubt, shown + curve.doubt, color=curve.colour, alpha=0.25, linewidth=0
            )
        above.plot(curve.rate, shown, curve.style, color=curve.colour, linewidth=1.8, label=curve.label)
    largest = max(float(np.max(np.abs(c.damping[driven(c.rate, rate)]), initial=0.0)) for c in curves)
    reach = max(1.3 * largest, float(np.quantile(np.abs(damping), 0.98)), 1e-9)
    above.set_ylim(-1.05 * reach, 1.05 * reach)
    above.axhline(0.0, color="#555555", linewidth=0.6)
    above.set_ylabel(f"damping d({words.symbol}) [{words.effort_unit}]")
    above.legend(loc="upper left")
    below.hist(rate, bins=60, color=MEASURED, alpha=0.45)
    below.set_yticks([])
    below.set_ylabel("samples", rotation=0, ha="right", va="center")
    below.grid(visible=False)
    below.set_xlabel(f"{words.rate} {words.symbol} [{words.rate_unit}]")
