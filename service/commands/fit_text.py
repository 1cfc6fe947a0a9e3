"""The text that `incsvr fit` prints."""

from __future__ import annotations

from incsvr.free_run.output_error import InertiaEstimate
from incsvr.plant.words import words_of
from service.commands.fit_result import Fit
from service.recordings import declared_inertia


def text(fit: Fit, estimate: InertiaEstimate | None) -> str:
    """The text of a fit, for people."""
    source = (
        "" if estimate is None else f"{declared_inertia.doubt(estimate, fit.closed_loop)}, estimated by output error"
    )
    if fit.inertia != fit.signals.inertia:
        source = f", traced ({fit.signals.inertia:.4g} declared)"
    signals, learner, words = fit.signals, fit.learner, words_of(fit.axis)
    rate_unit, unit = words.rate_unit, words.effort_unit
    of_estimate = declared_inertia.estimate_remarks(fit.closed_loop, words) if estimate else []
    left = fit.samples - (len(fit.iterations) + fit.put_aside) * learner.batch
    lines = [
        f"recordings  {fit.name}: {fit.samples} samples, {len(fit.iterations)} batches of {learner.batch}, {left} "
        "unused" + f", {fit.put_aside} batches put aside" * bool(fit.put_aside),
        f"vehicle     {words.inertia_symbol} = {fit.inertia:.4g} {words.inertia_unit}{source}; |{words.symbol}| ≤ "
        f"{learner.rate_range[1]:.3g} {rate_unit}",
        f"signals     a sample every {signals.sample_period:.3g} s, smoothed over {signals.smoothing:.3g} s",
        f"learner     policy {learner.policy}, γ = {learner.gamma:.3g} {words.kernel_unit}, C = {learner.C:.3g} "
        f"{unit}, ε = {learner.epsilon:.2g} {unit}",
        *([f"inputs      {', '.join((fit.axis.rate, *learner.others))}"] if learner.others else []),
        *([f"effects     {', '.join(fit.effects)}"] if fit.effects else []),
        *(f"remark      {remark}" for remark in (*of_estimate, *fit.remarks)),
        *(f"refused     {count} messages: {reason}" for reason, count in fit.rejected.items()),
        "",
        "iteration   until s   vectors   batch, before learning it" + ("   unseen runs" * bool(fit.errors)),
        f"                                MAE {unit}" + f"                     MAE, RMSE {unit}" * bool(fit.errors),
    ]
    for k, iteration in enumerate(fit.iterations):
        before = "–" if iteration.progressive_mae is None else f"{iteration.progressive_mae:.3g}"
        errors = fit.errors[k] if fit.errors else None
        after = "" if errors is None else f"{errors.mae:.3g}, {errors.rmse:.3g}"
        size = iteration.model.support_rate.size
        lines.append(
            f"{iteration.number:9d} {iteration.time_span[1]:9.1f} {size:9d}   {before:<25s}   {after}".rstrip()
        )
    final = fit.errors[-1] if fit.errors else None
    if final is not None:
        ran = "runs away" if fit.free_run_rmse is None else f"RMSE {fit.free_run_rmse:.4f} {rate_unit}"
        lines += [
            "",
            f"on {fit.validated_on}: MAE {final.mae:.3g} {unit}, RMSE {final.rmse:.3g} {unit}; free run {ran}",
        ]
    return "\n".join([*lines, "", *_coefficients(fit)])


def _coefficients(fit: Fit) -> list[str]:
    """The textbook's two, with what is to be known of them."""
    words = words_of(fit.axis)
    units = (words.linear_unit, words.quadratic_unit)
    told = [
        f"{name} = {value.estimate:.3g} ({value.low:.3g} to {value.high:.3g}) {unit}"
        for name, value, unit in zip((words.linear, words.quadratic), fit.coefficients.values(), units, strict=True)
    ]
    return [f"damping     {', '.join(told)}", *(f"            {note}" for note in fit.coefficient_notes)]
