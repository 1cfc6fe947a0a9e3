"""The charts of a trace and of a fit, each an SVG. Before and after differ in line style and mark, and in colour."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from incsvr.numerics import Array, root_mean_square
from incsvr.plant.axes import YAW, Axis
from incsvr.plant.body import DECLARED_INERTIA
from incsvr.plant.words import YAW_WORDS, AxisWords, words_of
from incsvr.tracing.findings import Pictures
from incsvr.tracing.held_out import Errors
from incsvr.tracing.model import TracedModel
from viewer.drawing import (
    AFTER,
    BEFORE,
    MEASURED,
    PARTS,
    Line,
    binned,
    dots,
    driven,
    edges,
    longest,
    rate_label,
    run_chart,
    svg,
)

WITHOUT, WITH = "without the effects", "with the effects"
"""What lines before and after a trace are called."""
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
    above.fill_between(centre, low, high, color="#9aa5b1", alpha=0.22, linewidth=0, label="90 % of the samples")
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
    below.set_xlabel(rate_label(axis))


UNITS = {
    "yaw_rate": "{rate} {symbol} [{rate_unit}]",
    "torque": "{effort} τ [{effort_unit}]",
    "heading": "heading ψ [rad]",
    "time": "time t [s]",
}
HINTS = {
    "yaw_rate": "A bend or a slope: the damping has another shape. A step at zero: dry friction.",
    "torque": "A slope: thrust or {inertia} is another than declared. A step at zero: a dead zone. Ends that bend: "
    "saturation. Another slope to each side: weak reverse thrust.",
    "heading": "One wave in a turn: a current. Two: a Munk moment. A straight line: a tether.",
    "time": "A slope: something drifts. A step: something changed at that instant.",
}
OF_CHANNEL = "A slope: the channel makes a {moment} of its own. Wider shading to one side: it scales thrust or damping."
"""How the residual over any other channel is read."""
MIN_VISIBLE_SHARE = 0.3
"""Smallest line that is drawn, in a residual's deviation: less is hidden by the shaded half of the samples."""
DRAWN_TIME_SCALES = 30.0
"""Time scales of the motion of each that are drawn: as much as an eye can follow."""
SAME_MOTION_SHARE = 0.02
"""Distance within which two pieces show the same motion, in the measured rates' reach."""


def told_apart(depends: Mapping[str, Array], before: Array, after: Array) -> tuple[dict[str, Array], tuple[str, ...]]:
    """What there is something to see against, and the names of the rest.

    Rate, torque, heading and time are always shown, another channel where the bins' medians of either residual vary by
    more than MIN_VISIBLE_SHARE of that residual.
    """
    moving = {name: x for name, x in depends.items() if np.isfinite(x).any() and np.nanstd(x) > 0.0}
    flat = [
        name
        for name, x in moving.items()
        if name not in UNITS
        and all(np.std(binned(x, each, edges(x))[2]) < MIN_VISIBLE_SHARE * np.nanstd(each) for each in (before, after))
    ]
    return {name: x for name, x in moving.items() if name not in flat}, tuple(flat)


def residual_against(name: str, x: Array, before: Array, after: Array, axis: Axis = YAW) -> str:
    """Median residual over bins of a quantity, with the middle half of the samples shaded."""
    words = words_of(axis)

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        bounds = edges(x)
        axes.axhline(0.0, color="#555555", linewidth=0.8)
        shown = ((before, BEFORE, "--", "s", WITHOUT), (after, AFTER, "-", "o", WITH))
        for residual, colour, style, mark, label in shown[1:] if np.array_equal(before, after) else shown:
            centre, low, middle, high = binned(x, residual, bounds)
            axes.fill_between(centre, low, high, color=colour, alpha=0.13, linewidth=0)
            axes.plot(centre, middle, style, color=colour, marker=mark, markersize=3.2, linewidth=1.4, label=label)
        # one scale for all panels, so that they can be compared
        reach = 1.1 * float(np.quantile(np.abs(np.concatenate([before, after])), 0.95))
        axes.set_ylim(-reach, reach)
        axes.set_xlabel(words.fill(UNITS[name]) if name in UNITS else name.replace("_", " "))
        axes.set_ylabel(f"residual [{words.effort_unit}]")
        axes.legend(loc="best", handlelength=2.2)

    return svg(draw, 3.4, 2.4)


def hint(name: str, words: AxisWords = YAW_WORDS) -> str:
    """How to read the residual over a quantity."""
    return words.fill(HINTS.get(name, OF_CHANNEL))


def free_runs(before: Errors, after: Errors, scale: float, axis: Axis = YAW) -> list[str]:
    """The rate simulated from the torque alone beside the measured one, in the longest unseen pieces, a chart each."""
    runs = (free_run(before, after, k, scale) for k in longest(after.time))
    return [run_chart(run, rate_label(axis)) for run in runs]


def free_run(before: Errors, after: Errors, k: int, scale: float) -> list[Line]:
    """The k-th unseen piece: measured, and simulated before and after; `scale` is the motion's [s]."""
    begin = float(after.time[k][0])
    end = min(float(after.time[k][-1]), begin + DRAWN_TIME_SCALES * scale)
    here = after.time[k] <= end
    lines = [Line("measured", after.time[k][here], after.measured[k][here])]
    nothing_added = np.array_equal(before.simulated[k], after.simulated[k]) if k < len(before.time) else False
    for time, simulated in [] if nothing_added else _same_motion(before, after, k, begin, end):
        lines.append(Line(f"simulated {WITHOUT}" if len(lines) == 1 else None, time, simulated, BEFORE, "--", 1.3))
    return [*lines, Line(f"simulated {WITH}", after.time[k][here], after.simulated[k][here], AFTER, width=1.5)]


def _same_motion(before: Errors, after: Errors, k: int, begin: float, end: float) -> list[tuple[Array, Array]]:
    """Stamps and simulated rates of the free runs before, within the span of the piece `k` after: another inertia has
    other pieces, and the stamps of recordings may overlap, so a piece is known by its measured rates."""
    found = []
    reach = max(float(np.ptp(after.measured[k])), 1e-12)
    for time, measured, simulated in zip(before.time, before.measured, before.simulated, strict=True):
        here = (time >= begin) & (time <= end)
        if np.count_nonzero(here) < 2:
            continue
        apart = np.abs(np.interp(time[here], after.time[k], after.measured[k]) - measured[here])
        if float(np.median(apart)) <= SAME_MOTION_SHARE * reach:
            found.append((time[here], simulated[here]))
    return found


def damping_curves(declared: TracedModel, traced: TracedModel, pictures: Pictures, axis: Axis = YAW) -> str:
    """The learned damping without and with the effects, over the samples that the fitted recordings show with them."""
    rate = pictures.depends["yaw_rate"]
    kept = np.isfinite(rate) & np.isfinite(pictures.residual_after)
    rate = rate[kept]
    samples = traced.damping_at(rate) + pictures.residual_after[kept]
    curves = (
        Curve(WITHOUT, declared.rate, declared.damping, BEFORE, "--"),
        Curve(WITH, traced.rate, traced.damping, AFTER, "-"),
    )
    nothing_added = np.array_equal(declared.damping, traced.damping)
    return damping_chart(curves[1:] if nothing_added else curves, rate, samples, axis)


def torque_split(parts: Mapping[str, Array], axis: Axis = YAW) -> str:
    """The torque ledger: how much each part takes, as root mean square."""
    size = {name: root_mean_square(values) for name, values in parts.items()}

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        names = [f"declared {words_of(axis).inertia}" if name == DECLARED_INERTIA else name for name in size]
        axes.barh(names, list(size.values()), color=[PARTS[k % len(PARTS)] for k in range(len(names))], height=0.62)
        largest = max(size.values())
        for row, value in enumerate(size.values()):
            axes.text(value + 0.015 * largest, row, f"{value:.3g}", va="center", fontsize=9, color="#333333")
        axes.set_xlim(0.0, 1.14 * largest)
        axes.invert_yaxis()
        axes.grid(visible=False, axis="y")
        axes.set_xlabel(f"root mean square [{words_of(axis).effort_unit}]")

    return svg(draw, 4.7, max(1.6, 0.9 + 0.42 * len(size)))
