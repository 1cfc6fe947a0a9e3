"""The text of a fit for people: how it went, the damping curve, the errors, and what the curve is good enough for."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from incsvr.learning.coefficients import NORMAL_95_DEVIATIONS
from incsvr.plant.words import words_of
from service.fitting import declared
from service.fitting.good_enough import compared_words, good_enough_lines

if TYPE_CHECKING:
    from service.fitting.fit import Fit

CURVE_COLUMNS = 7
"""Rates of the curve that fit beside one another in 80 columns."""


def text(fit: Fit) -> str:
    """The text of a fit, for people."""
    training, estimate, words = fit.training, fit.estimate, words_of(fit.axis)
    signals, learner, samples = training.signals, training.settings, len(training.samples)
    doubt = "" if estimate is None else declared.doubt(estimate.standard_error, fit.closed_loop)
    source = "" if estimate is None else f"{doubt}, estimated by output error"
    if fit.inertia != signals.inertia:
        source = f", traced ({signals.inertia:.4g} declared)"
    rate_unit, unit = words.rate_unit, words.effort_unit
    left = samples - (len(training.iterations) + fit.put_aside) * learner.batch
    lines = [
        f"recordings  {fit.name}: {samples} samples, {len(training.iterations)} batches of {learner.batch}, {left} "
        "unused" + f", {fit.put_aside} batches put aside" * bool(fit.put_aside),
        f"vehicle     {words.inertia_symbol} = {fit.inertia:.4g} {words.inertia_unit}{source}; |{words.symbol}| ≤ "
        f"{learner.rate_range[1]:.3g} {rate_unit}",
        f"signals     a sample every {signals.sample_period:.3g} s, smoothed over {signals.smoothing:.3g} s",
        f"learner     policy {learner.policy}, γ = {learner.gamma:.3g} {words.kernel_unit}, C = {learner.C:.3g} "
        f"{unit}, ε = {learner.epsilon:.2g} {unit}",
        *([f"inputs      {', '.join((fit.axis.rate, *learner.others))}"] if learner.others else []),
        *([f"effects     {', '.join(fit.effects)}"] if fit.effects else []),
        *(f"remark      {remark}" for remark in fit.remarks),
        *(f"refused     {count} messages: {reason}" for reason, count in training.rejected.items()),
        "",
        "iteration   until s   vectors   batch, before learning it" + ("   unseen runs" * bool(training.errors)),
        f"                                MAE {unit}"
        + f"                     MAE, RMSE {unit}" * bool(training.errors),
    ]
    for k, iteration in enumerate(training.iterations):
        before = "–" if iteration.progressive_mae is None else f"{iteration.progressive_mae:.3g}"
        errors = training.errors[k] if training.errors else None
        after = "" if errors is None else f"{errors.mae:.3g}, {errors.rmse:.3g}"
        size = iteration.model.support_rate.size
        lines.append(
            f"{iteration.number:9d} {iteration.time_span[1]:9.1f} {size:9d}   {before:<25s}   {after}".rstrip()
        )
    return "\n".join([*lines, "", *_curve(fit), "", *_errors(fit), "", *good_enough_lines(fit.uses)])


def _curve(fit: Fit) -> list[str]:
    """The curve as a small table, and the textbook's two coefficients where their signs are certain."""
    words, model = words_of(fit.axis), fit.model
    rates = np.linspace(*(model.trained_range or (0.0, 0.0)), CURVE_COLUMNS)
    curve = model.predict(rates)
    rows = [
        (f"{words.rate} [{words.rate_unit}]", rates),
        (f"damping [{words.effort_unit}]", curve.damping),
        ("± (95 %)", NORMAL_95_DEVIATIONS * curve.doubt),
    ]
    return [f"{name:<22}{''.join(f'{_figure(value):>8}' for value in values)}" for name, values in rows] + (
        [f"coefficients: {', '.join(fit.coefficient_notes)}"] if fit.coefficient_notes else _coefficients(fit)
    )


def _figure(value: float) -> str:
    return f"{value + 0.0:.3g}" if abs(value) >= 1e-12 else "0"


def _errors(fit: Fit) -> list[str]:
    """The errors on recordings that were not learned, or the free run on those that were."""
    errors, words, run = fit.training.errors, words_of(fit.axis), fit.free_run
    final = errors[-1] if errors else None
    unit = words.effort_unit
    lines = (
        []
        if final is None
        else [f"on {fit.validated_on}: MAE {final.mae:.3g} {unit}, RMSE {final.rmse:.3g} {unit} of the {words.effort}"]
    )
    where = fit.pictures.where + ("" if fit.pictures.unseen else ", which was learned")
    return [*lines, f"free run on {where}: {compared_words(run.model, run.zero, run.hold, words)}"]


def _coefficients(fit: Fit) -> list[str]:
    """The textbook's two."""
    words = words_of(fit.axis)
    units = (words.linear_unit, words.quadratic_unit)
    found = [
        f"{name} = {value.estimate:.3g} ({value.low:.3g} to {value.high:.3g}) {unit}"
        for name, value, unit in zip((words.linear, words.quadratic), fit.coefficients.values(), units, strict=True)
    ]
    return [f"coefficients: {', '.join(found)}"]
