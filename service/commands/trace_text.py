"""The text that `incsvr trace` prints."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from incsvr.plant.words import words_of
from incsvr.tracing.findings import Trace
from incsvr.tracing.sentences import chance, headline, limits, proof


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
    lines += [f"  not added: {r.effect}: {r.reason}" for r in trace.rejected if r.taken_back]
    lines += [f"  ignored channel {name}: {reason}" for name, reason in trace.ignored_channels.items()]
    lines += [f"  note: {note}" for note in trace.notes]
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
