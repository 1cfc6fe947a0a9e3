"""The page of a trace: what was found, in plain sentences and tables, around the charts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from incsvr.learning.coefficients import negative_drag
from incsvr.numerics import Array
from incsvr.plant.axes import YAW, Axis
from incsvr.plant.words import AxisWords, words_of
from incsvr.tracing.findings import Finding, Trace
from incsvr.tracing.sentences import LABELS, chance, headline, left_of_torque, limits, proof
from viewer.charts import damping_curves, free_runs, hint, residual_against, told_apart, torque_split
from viewer.report.figures import capital, number, rendered

BLOCK_TIME_SCALES = 4.0
"""Time scales of the motion in a block of the bootstrap: well above the residual's correlation time."""
BOOTSTRAP_DRAWS = 1000
"""Draws of the bootstrap."""


class Derivative(NamedTuple):
    """One of them, positive where it opposes the motion; without an interval it was declared, and not found.

    Attributes:
        interval: of 95 %.
    """

    symbol: str
    value: float
    interval: tuple[float, float] | None
    unit: str


def derivatives(trace: Trace, axis: Axis = YAW) -> tuple[list[Derivative], tuple[float, float]]:
    """The derivatives, and the rates that they hold for [rad/s].

    N_r and N_{r|r|} are those of the least squares d(r) = N_r r + N_{r|r|} r|r| on the damping that the fitted
    recordings show, d(r) and what the model leaves; their intervals are a moving-block bootstrap's (H. R. Künsch, Ann.
    Stat. 17, 1989).
    """
    pictures, model = trace.pictures, trace.model
    rate = pictures.depends["yaw_rate"]
    kept = np.isfinite(rate) & np.isfinite(pictures.residual_after)
    rate = rate[kept]
    damping = model.damping_at(rate) + pictures.residual_after[kept]
    terms = np.column_stack([rate, rate * np.abs(rate)])
    size = max(min(round(BLOCK_TIME_SCALES * model.scale / model.block), rate.size), 1)
    starts = range(0, rate.size - size + 1, max(size // 2, 1))
    normal = np.array([terms[a : a + size].T @ terms[a : a + size] for a in starts])
    score = np.array([terms[a : a + size].T @ damping[a : a + size] for a in starts])
    drawn = np.random.default_rng(0).integers(len(normal), size=(BOOTSTRAP_DRAWS, max(rate.size // size, 1)))
    spread = np.array([_solved(normal[each].sum(axis=0), score[each].sum(axis=0)) for each in drawn])
    value = _solved(terms.T @ terms, terms.T @ damping)
    low, high = np.quantile(spread, [0.025, 0.975], axis=0)
    inertia = next((each for each in trace.effects if each.effect == "inertia"), None)
    total, between = trace.inertia, None
    if inertia is not None:
        (total, *_), (between, *_) = inertia.parameters.values(), inertia.interval.values()
    words = words_of(axis)
    with_added_mass = f"{words.inertia_symbol} − {words.linear}\u0307"
    return [
        Derivative(words.linear, float(value[0]), (float(low[0]), float(high[0])), words.linear_unit),
        Derivative(words.quadratic, float(value[1]), (float(low[1]), float(high[1])), words.quadratic_unit),
        Derivative(with_added_mass, total, between, words.inertia_unit),
    ], (float(rate.min()), float(rate.max()))


def _solved(normal: Array, score: Array) -> Array:
    # at one rate alone the two cannot be told apart
    return np.asarray(np.linalg.pinv(normal, hermitian=True) @ score)


ERRORS = (
    ("torque_mae", "{effort}, mean absolute error", "{effort_unit}"),
    ("torque_rmse", "{effort}, root mean square error", "{effort_unit}"),
    ("free_run_rmse", "{rate} in free run, root mean square error", "{rate_unit}"),
)


def trace_page(trace: Trace, axis: Axis = YAW, provenance: Mapping[str, str] | None = None) -> str:
    """The whole document, in the words and units of an axis; `provenance` says what it was made of, and how."""
    pictures, words = trace.pictures, words_of(axis)
    coefficients, driven = derivatives(trace, axis)
    before, after = pictures.residual_before, pictures.residual_after
    seen, flat = told_apart(pictures.depends, before, after)
    left = left_of_torque(trace.error)
    declared = f"declared {words.inertia} {trace.inertia:g} {words.inertia_unit}"
    in_force = f", {trace.inertia_in_force:.3g} {words.inertia_unit} in use"
    return rendered(
        "trace.html.j2",
        axis,
        provenance,
        title="Trace",
        kicker=f"{words.title} motion model, {declared}{'' if trace.inertia_in_force == trace.inertia else in_force}",
        headline=[capital(clause.replace("_", " ")) for clause in (headline(trace), *limits(trace))],
        trace=trace,
        summary=_summary(trace, words),
        findings=[_finding(finding, words) for finding in trace.effects],
        errors=[(key, words.fill(label), words.fill(unit)) for key, label, unit in ERRORS],
        left=None if left is None else f"{number(100.0 * left)} %",
        validated_on=_validated_on(trace),
        derivatives=coefficients,
        flags=[flag for each in coefficients if (flag := _flag(each)) is not None],
        driven=driven,
        flat=flat,
        residuals=[(residual_against(name, x, before, after, axis), hint(name, words)) for name, x in seen.items()],
        free_runs=free_runs(pictures.before, pictures.after, trace.model.scale, axis),
        damping=damping_curves(trace.declared_model, trace.model, pictures, axis),
        split=torque_split(pictures.ledger, axis),
        chance=chance,
        probability=probability,
    )


def _flag(derivative: Derivative) -> str | None:
    """What is to be known of a derivative whose interval holds a negative drag."""
    return None if derivative.interval is None else negative_drag(derivative.symbol, *derivative.interval)


def probability(p_value: float) -> str:
    """A p-value for a table, three significant digits, never zero."""
    return chance(p_value, 3).removeprefix("= ").replace("-", "−")


def _validated_on(trace: Trace) -> str:
    if trace.error["validated_on"] == "recordings":
        return "recordings that were not used for the fit"
    return "held-out pieces of the recordings, each predicted by a fit without it"


def _summary(trace: Trace, words: AxisWords) -> str:
    error, unit = trace.error, words.rate_unit
    before, after = error["before"]["free_run_rmse"], error["after"]["free_run_rmse"]
    declared = f"On unseen data the free-run error of the {words.rate} is {number(before)} {unit}"
    if not trace.effects:
        return f"{declared}. Nothing was added."
    change = error["change"]["free_run_rmse"]
    return (
        f"{declared} with the declared model and {number(after)} {unit} with what was added: "
        f"{number(100.0 * (after / before - 1.0), '+')} % (95 % interval of the change {number(change['low'])} to "
        f"{number(change['high'])} {unit}). {capital(proof(trace))}."
    )


def _finding(finding: Finding, words: AxisWords) -> dict[str, Any]:
    rows = []
    for name, value in finding.parameters.items():
        label, unit = LABELS.get(name, (name.replace("_", " "), ""))
        low, high = finding.interval.get(name, (float("nan"), float("nan")))
        # a harmonic or a channel's mean is set, not fitted: it has no interval
        doubt = "set, not fitted" if low == high else f"{number(low)} to {number(high)}"
        rows.append((words.fill(label), number(value), doubt, words.fill(unit)))
    return {"finding": finding, "name": finding.effect.replace("_", " "), "rows": rows}
