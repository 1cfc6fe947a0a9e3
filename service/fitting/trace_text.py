"""The text of a trace for people, and what the model with its effects is good enough for."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from incsvr.plant.words import words_of
from incsvr.tracing.findings import Trace
from incsvr.tracing.sentences import chance, headline, limits, proof
from service.fitting.good_enough import Use, closed_loop, feed_forward, good_enough_lines, without_gyro


def uses(found: Trace) -> tuple[Use, ...]:
    """What the model with the effects is good enough for."""
    words, error = words_of(found.axis), found.error
    share = error["disturbance"].get("share_of_torque", 0.0)
    effort = error["disturbance"]["torque_rmse"] / share if share else 0.0
    zero, hold = (error["trivial"][name]["free_run_rmse"] for name in ("zero", "hold"))
    free = without_gyro(error["after"]["free_run_rmse"], zero, hold, words)
    free = closed_loop(free.use, words) if found.loop == "closed" else free
    return feed_forward(error["after"]["torque_rmse"], effort, words), free


def text(trace: Trace) -> str:
    """The findings for people."""
    words = words_of(trace.axis)
    traced = (
        ""
        if trace.inertia_in_force == trace.inertia
        else f" ({trace.inertia_in_force:.3g} {words.inertia_unit} in use)"
    )
    lines = [f"declared {words.inertia} {trace.inertia:g} {words.inertia_unit}{traced}: {headline(trace)}"]
    lines += [f"  caution: {limit}" for limit in limits(trace)]
    for finding in trace.effects:
        lines.append(f"  {finding.sentence}")
        if finding.cannot_tell_from:
            rivals = ", ".join(finding.cannot_tell_from)
            lines.append(f"    these recordings cannot distinguish it from: {rivals} (either, or both at once)")
        if finding.next_manoeuvre:
            lines.append(f"    next: {finding.next_manoeuvre}")
    lines += [f"  {item.channel} still predicts the residual (p {chance(item.p_value)})" for item in trace.unexplained]
    error = trace.error
    where = (
        "the validation recordings" if error["validated_on"] == "recordings" else "held-out pieces of the recordings"
    )
    lines.append(f"  on {where}:            before       after    change (95 %)")
    for key, unit in (("torque_rmse", words.effort_unit), ("free_run_rmse", words.rate_unit)):
        change = error["change"][key]
        lines.append(
            f"    {key:14s} [{unit:5s}]   {_figure(error['before'][key]):>10s}  {_figure(error['after'][key]):>10s}    "
            f"{_change(change['estimate'])} ({_change(change['low'])} to {_change(change['high'])})"
        )
    lines += _beside(error, trace.model.scale, words.rate_unit)
    if trace.effects or trace.loop == "closed":
        lines.append(f"  {proof(trace)}")
    lines.append(f"    noise floor of the {words.effort} {_figure(error['floor']['torque_rmse'])} {words.effort_unit}")
    left = error["disturbance"]
    share = f"{100.0 * left['share_of_torque']:.1f} % of the {words.effort}, " if "share_of_torque" in left else ""
    lines.append(
        f"    residual: {left['torque_rmse']:.3g} {words.effort_unit} (RMS), {share}correlated over "
        f"{left['correlation_time_s']:.2g} s"
    )
    lines += [f"  not added: {r.effect}: {r.reason}" for r in trace.rejected if r.refused]
    lines += [f"  ignored channel {name}: {reason}" for name, reason in trace.ignored_channels.items()]
    lines += [f"  note: {note}" for note in trace.notes]
    lines += ["", *good_enough_lines(uses(trace))]
    return "\n".join(lines)


def _beside(error: Mapping[str, Any], scale: float, unit: str) -> list[str]:
    """The trivial models, and the errors a few time scales ahead, each of so many seconds."""
    zero, hold = (_figure(error["trivial"][name]["free_run_rmse"]) for name in ("zero", "hold"))
    lines = [f"    for comparison [{unit}]: zero rate {zero}, first rate held {hold}"]
    for horizon, errors in error["horizons"].items():
        said = ", ".join(f"{name} {_figure(errors[name])}" for name in ("before", "after", "hold", "zero"))
        lines.append(f"    {horizon:>4s} time scales ({float(horizon) * scale:.2g} s) ahead [{unit}]: {said}")
    return lines


def _figure(value: float) -> str:
    return f"{value:.4g}" if math.isfinite(value) else "–"


def _change(value: float) -> str:
    return f"{value:+.3g}" if math.isfinite(value) else "–"
