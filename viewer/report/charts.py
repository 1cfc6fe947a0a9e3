"""The charts of the report, each an SVG text. Before and after differ in line style and mark as well as in colour."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from incsvr.plant.axes import YAW, Axis
from incsvr.plant.body import DECLARED_INERTIA
from incsvr.plant.words import said
from incsvr.samples import Array
from incsvr.tracing.held_out import Errors
from incsvr.tracing.model import TracedModel

# Okabe and Ito's palette: told apart by colour-blind readers, and in grey by lightness.
BEFORE, AFTER, MEASURED = "#d55e00", "#0072b2", "#222222"
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
    "svg.fonttype": "none",
    "svg.hashsalt": "incsvr",  # the same trace gives the same file
}
UNITS = {
    "yaw_rate": "yaw rate r [rad/s]",
    "torque": "torque τ [N m]",
    "heading": "heading ψ [rad]",
    "time": "time t [s]",
}
BINS = 24
VISIBLE = 0.3  # of a residual's deviation: less is hidden within the shaded half of its samples
LONGEST_POLYLINE = 1500  # points of a line: more than a page can show, few enough for a small file


def told_apart(depends: Mapping[str, Array], before: Array, after: Array) -> tuple[dict[str, Array], tuple[str, ...]]:
    """What there is something to see against, and the names of the rest.

    Rate, torque, heading and time are always shown, another channel where the bins' medians of either residual vary by
    more than VISIBLE of that residual.
    """
    moving = {name: x for name, x in depends.items() if np.isfinite(x).any() and np.nanstd(x) > 0.0}
    flat = [
        name
        for name, x in moving.items()
        if name not in UNITS
        and all(np.std(_binned(x, each, _edges(x))[2]) < VISIBLE * np.nanstd(each) for each in (before, after))
    ]
    return {name: x for name, x in moving.items() if name not in flat}, tuple(flat)


def residual_against(shown: Mapping[str, Array], before: Array, after: Array, axis: Axis = YAW) -> str:
    """Median residual, binned over each of these quantities, with the middle half of the samples shaded."""
    rows = -(-len(shown) // 3)

    def draw(figure: Figure) -> None:
        grid = figure.subplots(rows, 3, sharey=True, squeeze=False)
        for axes in grid.flat[len(shown) :]:
            axes.set_visible(False)
        for axes, (name, x) in zip(grid.flat, shown.items(), strict=False):
            edges = _edges(x)
            axes.axhline(0.0, color="#555555", linewidth=0.8)
            for residual, color, style, mark, label in (
                (before, BEFORE, "--", "s", "before"),
                (after, AFTER, "-", "o", "after"),
            ):
                centre, low, middle, high = _binned(x, residual, edges)
                axes.fill_between(centre, low, high, color=color, alpha=0.13, linewidth=0)
                axes.plot(centre, middle, style, color=color, marker=mark, markersize=3.2, linewidth=1.4, label=label)
            axes.set_xlabel(said(axis, UNITS[name]) if name in UNITS else name.replace("_", " "))
        for axes in grid[:, 0]:
            axes.set_ylabel(said(axis, "residual [N m]"))
        grid.flat[0].legend(loc="best", ncols=2, handlelength=2.2)

    return _svg(draw, 9.6, 2.5 * rows)


def free_runs(before: Errors, after: Errors, scale: float, axis: Axis = YAW) -> str:
    """The yaw rate simulated from the torque alone beside the measured one, in the three longest unseen pieces."""
    longest = sorted(range(len(after.time)), key=lambda k: -after.time[k].size)[:3]
    longest.sort(key=lambda k: after.time[k][0] if after.time[k].size else 0.0)

    def draw(figure: Figure) -> None:
        grid = figure.subplots(len(longest), 1, squeeze=False)[:, 0]
        for axes, k in zip(grid, longest, strict=True):
            # Thirty time scales of the vehicle are as much as an eye can follow.
            here = after.time[k] <= after.time[k][0] + 30.0 * scale
            time = after.time[k][here]
            _line(axes, time, after.measured[k][here], color=MEASURED, linewidth=1.1, label="measured")
            _line(axes, time, before.simulated[k][here], color=BEFORE, linestyle="--", linewidth=1.3, label="before")
            _line(axes, time, after.simulated[k][here], color=AFTER, linewidth=1.5, label="after")
            axes.set_ylabel(said(axis, "r [rad/s]"))
            axes.margins(x=0.01)
        grid[-1].set_xlabel("time t [s]")
        figure.legend(*grid[0].get_legend_handles_labels(), loc="outside upper right", ncols=3)

    return _svg(draw, 9.6, 0.4 + 1.9 * len(longest))


def damping_curves(declared: TracedModel, traced: TracedModel, rate: Array, axis: Axis = YAW) -> str:
    """The learned damping without and with the effects, over the rates that were driven."""

    def draw(figure: Figure) -> None:
        curve, driven = figure.subplots(2, 1, sharex=True, height_ratios=(5, 1))
        curve.plot(declared.rate, declared.damping, "--", color=BEFORE, linewidth=1.6, label="before")
        curve.plot(traced.rate, traced.damping, color=AFTER, linewidth=1.8, label="after")
        curve.set_ylabel(said(axis, "damping d(r) [N m]"))
        curve.legend(loc="upper left")
        driven.hist(rate, bins=60, color="#9aa5b1")
        driven.set_yticks([])
        driven.set_ylabel("driven", rotation=0, ha="right", va="center")
        driven.grid(visible=False)
        driven.set_xlabel(said(axis, UNITS["yaw_rate"]))

    return _svg(draw, 4.7, 3.6)


def torque_split(parts: Mapping[str, Array], axis: Axis = YAW) -> str:
    """The torque ledger: how much each part takes, as root mean square."""
    size = {name: float(np.sqrt(np.mean(values**2))) for name, values in parts.items()}

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        names = [said(axis, name) if name == DECLARED_INERTIA else name for name in size]
        axes.barh(names, list(size.values()), color=[PARTS[k % len(PARTS)] for k in range(len(names))], height=0.62)
        largest = max(size.values())
        for row, value in enumerate(size.values()):
            axes.text(value + 0.015 * largest, row, f"{value:.3g}", va="center", fontsize=9, color="#333333")
        axes.set_xlim(0.0, 1.14 * largest)
        axes.invert_yaxis()
        axes.grid(visible=False, axis="y")
        axes.set_xlabel(said(axis, "root mean square [N m]"))

    return _svg(draw, 4.7, max(1.6, 0.9 + 0.42 * len(size)))


def _edges(x: Array) -> Array:
    """Bins of equal count, but none narrower than a fiftieth of the range: held commands pile up at few values."""
    quantiles = np.nanquantile(x, np.linspace(0.0, 1.0, BINS + 1))
    narrowest = 0.02 * (quantiles[-1] - quantiles[0])
    edges = [quantiles[0]]
    for edge in quantiles[1:]:
        if edge - edges[-1] >= narrowest:
            edges.append(edge)
    return np.array(edges)


def _binned(x: Array, y: Array, edges: Array) -> tuple[Array, Array, Array, Array]:
    """Centre of each bin, and the lower quartile, mean and upper quartile of y in it; sparse bins are left out."""
    bin_of = np.digitize(x, edges[1:-1])
    rows = []
    for k in range(edges.size - 1):
        here = (bin_of == k) & np.isfinite(x)
        if np.count_nonzero(here) >= 5:
            low, high = np.quantile(y[here], [0.25, 0.75])
            rows.append((np.median(x[here]), low, np.median(y[here]), high))
    columns = np.array(rows).reshape(-1, 4).T
    return columns[0], columns[1], columns[2], columns[3]


def _line(axes: Axes, x: Array, y: Array, **style: Any) -> None:
    every = max(1, x.size // LONGEST_POLYLINE)
    axes.plot(x[::every], y[::every], **style)


def _svg(draw: Callable[[Figure], None], width: float, height: float) -> str:
    """What `draw` puts on a figure of so many inches, as an <svg> element that scales with the page."""
    with rc_context(STYLE):
        figure = Figure(figsize=(width, height), layout="constrained")
        draw(figure)
        text = io.StringIO()
        figure.savefig(text, format="svg", transparent=True, metadata={"Date": None, "Creator": None})
    svg = text.getvalue()
    svg = svg[svg.index("<svg") :]
    return re.sub(r'<svg ([^>]*?)height="[^"]+"([^>]*?)width="[^"]+"', r"<svg \1\2", svg, count=1)
