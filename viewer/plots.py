"""What `plot()` of a result draws, as a figure of matplotlib that a notebook shows and `savefig` keeps."""

from __future__ import annotations

from typing import Any

from matplotlib import pyplot, ticker

from incsvr.forecasting.over_recordings import FitPictures
from incsvr.plant.axes import AXES, YAW, Axis
from incsvr.plant.words import words_of
from incsvr.tracing.findings import Trace
from incsvr.vehicle import Comparison, Identified
from viewer.charts import draw_damping, free_run
from viewer.drawing import AFTER, BEFORE, STYLE, longest, over_time, rate_label
from viewer.log_plot import of_log
from viewer.report.dives_page import draw as draw_dives
from viewer.report.fit_page import learned_curve

__all__ = ["of_comparison", "of_fit", "of_log", "of_trace", "of_vehicle"]


def of_fit(pictures: FitPictures, axis: Axis = YAW) -> Any:
    """The learned damping curve beside its samples."""
    with pyplot.rc_context(STYLE):
        figure = pyplot.figure(figsize=(6.5, 5.0), layout="constrained")
        draw_damping(figure, [learned_curve(pictures)], pictures.samples.yaw_rate, pictures.samples.damping, axis)
    return figure


def of_trace(trace: Trace, axis: Axis = YAW) -> Any:
    """The longest free run on unseen data, before and after."""
    after = trace.pictures.after
    with pyplot.rc_context(STYLE):
        figure = pyplot.figure(figsize=(8.0, 3.5), layout="constrained")
        (k,) = longest(after.time, 1)
        lines = free_run(trace.pictures.before, after, k, trace.model.scale)
        over_time(figure, lines, rate_label(axis))
    return figure


def of_vehicle(identified: Identified) -> Any:
    """Prediction errors of a whole vehicle over how far ahead they look, one plot an axis."""
    errors = identified.errors
    seconds, across = list(errors.horizons), min(len(errors.axes), 3)
    down = -(-len(errors.axes) // across)
    with pyplot.rc_context(STYLE):
        figure = pyplot.figure(figsize=(3.0 * across, 2.4 * down + 0.4), layout="constrained")
        plots = figure.subplots(down, across, squeeze=False).ravel()
        for spare in plots[len(errors.axes) :]:
            spare.remove()
        for k, (plot, axis) in enumerate(zip(plots, errors.axes, strict=False)):
            model, hold = ([errors.horizons[ahead][which][k] for ahead in seconds] for which in (0, 1))
            plot.loglog(seconds, hold, "s--", color=BEFORE, label="first velocity kept")
            plot.loglog(seconds, model, "o-", color=AFTER, label="predicted by the model")
            plot.set_xticks(seconds, [f"{ahead:g}" for ahead in seconds], minor=False)
            plot.minorticks_off()
            plot.yaxis.set_major_locator(ticker.LogLocator(subs=(1.0, 2.0, 5.0)))
            plot.yaxis.set_major_formatter("{x:g}")
            plot.set_title(axis)
            plot.set_xlabel("time ahead [s]")
            plot.set_ylabel(f"RMS error [{words_of(AXES[axis]).rate_unit}]")
        figure.legend(*plots[0].get_legend_handles_labels(), loc="outside upper right", ncols=2)
    return figure


def of_comparison(compared: Comparison) -> Any:
    """Each quantity over the dives with its interval of 95 %, one plot a quantity; a change stands out."""
    across = min(len(compared.quantities), 3)
    down = -(-len(compared.quantities) // across)
    with pyplot.rc_context(STYLE):
        figure = pyplot.figure(figsize=(4.0 * across, 2.8 * down), layout="constrained")
        parts = figure.subfigures(down, across, squeeze=False).ravel()
        for part, quantity, values in zip(parts, compared.quantities, compared.values, strict=False):
            draw_dives(part, quantity, compared.dives, values)
    return figure
