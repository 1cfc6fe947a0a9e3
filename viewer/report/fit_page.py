"""The page of a fit: what was learned, how sure it is, and how far it carries on recordings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from incsvr.forecasting.over_recordings import FitPictures, FreeRun
from incsvr.numerics import root_mean_square
from incsvr.plant.axes import YAW, Axis
from incsvr.plant.words import AxisWords, words_of
from viewer.charts import Curve, damping_chart
from viewer.drawing import AFTER, BEFORE, longest, simulated_chart, svg
from viewer.report.figures import capital, number, rendered

NORMAL_95 = 1.96
COEFFICIENTS = (("{linear}", "{linear_unit}"), ("{quadratic}", "{quadratic_unit}"))
"""What the two of a result are called, and their units: templates of `AxisWords`."""


def fit_page(
    result: Mapping[str, Any], pictures: FitPictures, axis: Axis = YAW, provenance: Mapping[str, str] | None = None
) -> str:
    """The whole document, in the words and units of an axis.

    Args:
        result: what `incsvr fit --json` writes.
        pictures: what is drawn.
        provenance: what it was made of, and how.
    """

    words, declared, inertia = words_of(axis), result["declared"]["inertia"], result["inertia"]
    unit, samples = words.inertia_unit, pictures.samples
    in_use = "" if inertia == declared else f", {inertia:.3g} {unit} in use"
    return rendered(
        "fit.html.j2",
        axis,
        provenance,
        title="Fit",
        kicker=f"{words.title} damping, declared {words.inertia} {declared:g} {unit}{in_use}",
        headline=_headline(result, pictures, words),
        remarks=[capital(remark) for remark in result["remarks"]],
        coefficients=[
            (words.fill(name), each["estimate"], (each["low"], each["high"]), words.fill(unit))
            for (name, unit), each in zip(COEFFICIENTS, result["coefficients"].values(), strict=True)
        ],
        flags=result["coefficient_notes"],
        range=result["trained_range"],
        settings=_settings(result, words),
        damping=damping_chart([learned_curve(pictures)], samples.yaw_rate, samples.damping, axis),
        errors=_errors(result, axis),
        free_runs=_free_runs(pictures.free_runs, axis),
        where=f"{pictures.where}, {'which was not learned from' if pictures.unseen else 'which was learned from'}",
    )


def _headline(result: Mapping[str, Any], pictures: FitPictures, words: AxisWords) -> list[str]:
    """What was learned, then what limits it."""
    low, high = (number(end) for end in result["trained_range"])
    clauses = [f"The damping was learned from {result['samples']} samples, from {low} to {high} {words.rate_unit}"]
    runs = pictures.free_runs
    if runs:
        measured = np.concatenate([run.measured for run in runs])
        error = root_mean_square(np.concatenate([run.error for run in runs]))
        zero = root_mean_square(measured)
        seen = "unseen" if pictures.unseen else "the same"
        ran = f"errs by {number(error)} {words.rate_unit}" if np.isfinite(error) else "runs away"
        clauses.append(
            f"On {seen} recordings the free run {ran}, where a rate of zero errs by {number(zero)} {words.rate_unit}"
        )
        if not error < zero:
            clauses.append(f"So it predicts no better than a rate of zero: check {words.inertia}, units and signs")
    if result["remarks"]:
        count = len(result["remarks"])
        which = "the remark" if count == 1 else f"the {count} remarks"
        clauses.append(f"Read {which} below before the curve is used")
    return clauses


def _settings(result: Mapping[str, Any], words: AxisWords) -> list[tuple[str, str]]:
    signals, learner, unit = result["settings"]["signals"], result["settings"]["learner"], words.effort_unit
    rows = [
        ("a sample every", f"{number(signals['sample_period'])} s, smoothed over {number(signals['smoothing'])} s"),
        (f"the {words.effort} counts as", str(signals["torque"] or "inferred from the data")),
        ("policy", f"{learner['policy']}, {result['support_vectors']} vectors"),
        (
            "γ, C, ε",
            f"{number(learner['gamma'])} {words.kernel_unit}, {number(learner['C'])} {unit}, "
            f"{number(learner['epsilon'])} {unit}",
        ),
        ("batches", f"{result['iterations']} learned, {result['put_aside']} put aside"),
    ]
    return rows


def learned_curve(pictures: FitPictures) -> Curve:
    """The final model's damping over the rates that it was trained on, with its doubt."""
    model = pictures.model
    rate = np.linspace(*(model.trained_range or (0.0, 0.0)), 201)
    learned = model.predict(rate)
    return Curve("learned, with its 95 % interval", rate, learned.damping, AFTER, "-", NORMAL_95 * learned.doubt)


def _errors(result: Mapping[str, Any], axis: Axis) -> str:
    """The mean absolute error of each batch before it is learned, and on unseen recordings after it."""
    iterations = np.arange(1, result["iterations"] + 1)
    before = np.array([np.nan if each is None else each for each in result["progressive_mae"]], dtype=np.float64)
    unseen = np.array(
        [np.nan if each is None else each["mae"] for each in result["validation_per_iteration"]], dtype=np.float64
    )

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        for errors, style, colour, label in (
            (before, "s--", BEFORE, "the batch, before it is learned"),
            (unseen, "o-", AFTER, "unseen recordings"),
        ):
            if errors.size:
                axes.plot(iterations, errors, style, color=colour, markersize=4, linewidth=1.5, label=label)
        axes.set_ylim(bottom=0.0)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.set_xlabel("iteration")
        axes.set_ylabel(f"mean absolute error [{words_of(axis).effort_unit}]")
        axes.legend(loc="upper right")

    return svg(draw, 4.7, 3.2)


def _free_runs(runs: Sequence[FreeRun], axis: Axis, seconds: float = 30.0) -> list[str]:
    """The beginnings of the longest free runs, a chart each."""
    chosen = (runs[k] for k in longest([run.time for run in runs]))
    return [simulated_chart(axis, run.time, run.measured, run.simulated, seconds) for run in chosen]
