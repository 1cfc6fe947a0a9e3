"""The page of dives compared: each inertia and drag dive by dive with its interval, and since when it is another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from incsvr.plant.axes import AXES, YAW
from incsvr.plant.words import words_of
from incsvr.vehicle import Comparison
from incsvr.vehicle.changes import LEVEL
from incsvr.vehicle.compare import Quantity, Value
from viewer.drawing import AFTER, BEFORE, svg
from viewer.report.figures import between, capital, number, rendered

MAX_NAMED_DIVES = 12
"""Dives that are named below a chart; of more, numbers stand there, and the tables name them."""


def dives_page(
    compared: Comparison, explanations: Mapping[str, Sequence[str]], provenance: Mapping[str, str] | None = None
) -> str:
    """The whole document.

    Args:
        explanations: dive → the single causes that fit what changed in it, the likeliest first.
        provenance: what it was made of, and how.
    """
    rows = list(zip(compared.quantities, compared.values, strict=True))
    return rendered(
        "dives.html.j2",
        YAW,
        provenance,
        title="Dives compared",
        kicker=f"{len(compared.dives)} dives, {sum(each.seconds for each in compared.conditions):.0f} s of motion",
        headline=_headline(compared),
        level=f"{100.0 * LEVEL:.0f} %",
        shown=[f"{capital(each.sentence)}." for each in compared.shown],
        order=compared.order,
        explanations=[(dive, [capital(each) for each in found]) for dive, found in explanations.items()],
        charts=[chart(quantity, compared.dives, values) for quantity, values in rows],
        tables=[(quantity.name, quantity.unit, _rows(compared.dives, values)) for quantity, values in rows],
        dives=[
            (dive, f"{went.seconds:.0f}", [number(went.speed[list(AXES).index(axis)]) for axis in _axes(compared)])
            for dive, went in zip(compared.dives, compared.conditions, strict=True)
        ],
        axes=[(axis, words_of(AXES[axis]).rate_unit) for axis in _axes(compared)],
    )


def chart(quantity: Quantity, dives: Sequence[str], values: Sequence[Value]) -> str:
    """One quantity over the dives: its estimates with intervals, the means before, and the changes."""
    return svg(lambda figure: draw(figure, quantity, dives, values), 4.7, 2.4)


def draw(figure: Figure, quantity: Quantity, dives: Sequence[str], values: Sequence[Value]) -> None:
    """Draws the chart on a figure."""
    axes, place = figure.subplots(), np.arange(1, len(values) + 1)
    estimate = np.array([value.estimate for value in values])
    reach = np.array([[value.estimate - value.low, value.high - value.estimate] for value in values]).T
    changed = np.array([value.changed for value in values])
    for here, colour, mark, label in ((~changed, AFTER, "o", "dive, 95 %"), (changed, BEFORE, "D", "changed here")):
        if here.any():
            axes.errorbar(
                place[here],
                estimate[here],
                reach[:, here],
                color=colour,
                fmt=mark,
                markersize=5,
                capsize=2.5,
                label=label,
            )
    reference = np.array([np.nan if value.reference is None else value.reference for value in values])
    axes.hlines(reference, place - 0.4, place + 0.4, color="#888888", linewidth=1.2, label="mean before")
    for k in np.flatnonzero(changed):
        axes.axvline(place[k] - 0.5, color=BEFORE, linewidth=1.0, linestyle="--")
    axes.set_ylabel(f"{quantity.axis} {quantity.kind} [{quantity.unit}]")
    if len(dives) <= MAX_NAMED_DIVES:
        axes.set_xticks(place, dives, rotation=30, ha="right", fontsize=8)
    else:
        axes.set_xlabel("dive")
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.margins(x=0.04)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper right", ncols=3)


def _headline(compared: Comparison) -> list[str]:
    """What changed since when."""
    if not compared.changes:
        return ["No change proven"]
    return [
        capital(f"{quantity.name} changed by {_percent(value)} in {dive}") for dive, quantity, value in compared.changes
    ]


def _percent(value: Value) -> str:
    """By how much it differs from the mean before."""
    return f"{100.0 * (value.estimate / value.reference - 1.0):+.0f} %" if value.reference else "–"


def _axes(compared: Comparison) -> list[str]:
    """The axes that are compared."""
    return list(dict.fromkeys(quantity.axis for quantity in compared.quantities))


def _rows(dives: Sequence[str], values: Sequence[Value]) -> list[tuple[str, str, str, str, str, bool]]:
    """Dive, value, interval, mean before, p value and whether it changed."""
    return [
        (
            dive,
            number(value.estimate),
            between((value.low, value.high)),
            "–" if value.reference is None else number(value.reference),
            "–" if value.p_value is None else f"{value.p_value:.2g}",
            value.changed,
        )
        for dive, value in zip(dives, values, strict=True)
    ]
