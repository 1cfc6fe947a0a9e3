"""How results are drawn: colours, fonts and the way to SVG, lines over time, and samples in bins."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from incsvr.numerics import Array
from incsvr.plant.axes import Axis
from incsvr.plant.words import words_of

# Okabe and Ito's palette: told apart by colour-blind readers, and in grey by lightness.
BEFORE, AFTER, MEASURED, BEHIND = "#d55e00", "#0072b2", "#222222", "#b4bdc7"
PARTS = ("#0072b2", "#009e73", "#d55e00", "#cc79a7", "#8a6d00", "#56b4e9", "#555555", "#e69f00")
STYLE: dict[Any, Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["Helvetica", "Arial", "Liberation Sans", "DejaVu Sans"],
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#888888",
    "axes.labelcolor": "#333333",
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e4e7eb",
    "grid.linewidth": 0.7,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "legend.handlelength": 1.6,
    "legend.columnspacing": 1.2,
    "svg.fonttype": "none",
    "svg.hashsalt": "incsvr",  # the same trace gives the same file
}
MAX_BINS = 24
"""Bins of samples at most."""
MIN_BIN_SAMPLES = 8
"""Samples that a bin has at least in the mean."""
MAX_LINE_POINTS = 1500
"""Points of a line: more than a page can show, few enough for a small file."""
MAX_DOTS = 900
"""Samples that are drawn one by one, for the same reason."""
MAX_SAMPLE_DISTANCE_SHARE = 1.0 / 30.0
"""Part of the range of rates within which there is a sample where a curve is drawn: elsewhere nothing was driven."""


def edges(x: Array) -> Array:
    """Bins of equal count, but none narrower than a fiftieth of the range: held commands pile up at few values."""
    bins = int(np.clip(np.isfinite(x).sum() // MIN_BIN_SAMPLES, 1, MAX_BINS))
    quantiles = np.nanquantile(x, np.linspace(0.0, 1.0, bins + 1))
    narrowest = 0.02 * (quantiles[-1] - quantiles[0])
    found = [quantiles[0]]
    for edge in quantiles[1:]:
        if edge - found[-1] >= narrowest:
            found.append(edge)
    return np.array(found)


def binned(x: Array, y: Array, bounds: Array, middle: float = 0.5) -> tuple[Array, Array, Array, Array]:
    """Centre of each bin, and the low end, median and high end of the `middle` part of y in it; sparse bins are left
    out."""
    bin_of = np.digitize(x, bounds[1:-1])
    rows = []
    for k in range(max(bounds.size - 1, 1)):
        here = (bin_of == k) & np.isfinite(x)
        if np.count_nonzero(here) >= 5:
            low, high = np.quantile(y[here], [0.5 - 0.5 * middle, 0.5 + 0.5 * middle])
            rows.append((np.median(x[here]), low, np.median(y[here]), high))
    columns = np.array(rows).reshape(-1, 4).T
    return columns[0], columns[1], columns[2], columns[3]


def driven(rate: Array, samples: Array) -> NDArray[np.bool_]:
    """(n,) whether there is a sample (m,) near each of some rates (n,)."""
    ordered = np.sort(samples)
    place = np.clip(np.searchsorted(ordered, rate), 1, ordered.size - 1)
    nearest = np.minimum(np.abs(rate - ordered[place - 1]), np.abs(ordered[place] - rate))
    return np.asarray(nearest <= MAX_SAMPLE_DISTANCE_SHARE * float(np.ptp(ordered)))


def dots(axes: Axes, x: Array, y: Array, **style: Any) -> None:
    """Samples, thinned to what can be seen."""
    every = max(1, -(-x.size // MAX_DOTS))
    axes.plot(x[::every], y[::every], ".", **style)


@dataclass(frozen=True, slots=True)
class Line:
    """Values (n,) over time (n,) [s]; without a label it is not in the legend."""

    label: str | None
    time: Array
    value: Array
    colour: str = MEASURED
    style: str = "-"
    width: float = 1.1


def over_time(figure: Figure, lines: Sequence[Line], label: str) -> None:
    """Lines over time, thinned to what can be seen, with a legend above them; `label` names the values."""
    axes = figure.subplots()
    for each in lines:
        every = max(1, each.time.size // MAX_LINE_POINTS)
        (drawn,) = axes.plot(each.time[::every], each.value[::every], each.style, color=each.colour, label=each.label)
        drawn.set_linewidth(each.width)
    axes.set_ylabel(label)
    axes.set_xlabel("time t [s]")
    axes.margins(x=0.01)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper right", ncols=3)


def run_chart(lines: Sequence[Line], label: str) -> str:
    """A chart of lines over time."""
    return svg(lambda figure: over_time(figure, lines, label), 4.7, 2.5)


def rate_label(axis: Axis) -> str:
    """The rate of an axis with letter and unit: yaw rate r [rad/s]."""
    return words_of(axis).fill("{rate} {symbol} [{rate_unit}]")


def simulated_chart(axis: Axis, time: Array, measured: Array, simulated: Array, seconds: float) -> str:
    """A chart of the first `seconds` of a free run over what was measured, which a good model's line covers."""
    here = time <= time[0] + seconds
    lines = (
        Line("measured", time[here], measured[here], BEHIND, width=3.0),
        Line("simulated", time[here], simulated[here], AFTER, width=1.5),
    )
    return run_chart(lines, rate_label(axis))


def longest(times: Sequence[Array], pieces: int = 4) -> list[int]:
    """The longest pieces of more than one sample, in their order of time."""
    found = sorted(range(len(times)), key=lambda k: -times[k].size)[:pieces]
    return sorted((k for k in found if times[k].size > 1), key=lambda k: float(times[k][0]))


def svg(draw: Callable[[Figure], None], width: float, height: float) -> str:
    """What `draw` puts on a figure of so many inches, as an <svg> element that scales with the page."""
    with rc_context(STYLE):
        figure = Figure(figsize=(width, height), layout="constrained")
        draw(figure)
        text = io.StringIO()
        figure.savefig(text, format="svg", transparent=True, metadata={"Date": None, "Creator": None})
    found = text.getvalue()
    found = found[found.index("<svg") :]
    return re.sub(r'<svg ([^>]*?)height="[^"]+"([^>]*?)width="[^"]+"', r"<svg \1\2", found, count=1)
