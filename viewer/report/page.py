"""The page: what was found, in plain sentences and tables, around the charts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from incsvr.plant.axes import YAW, Axis
from incsvr.plant.words import said
from incsvr.tracing import Trace
from incsvr.tracing.findings import Finding
from incsvr.tracing.sentences import chance
from viewer.report.charts import damping_curves, free_runs, residual_against, told_apart, torque_split
from viewer.report.derivatives import derivatives

# The unit stands at the end of a parameter's name (CONTRACT, Section 5); the longest suffix wins.
SUFFIXES = (
    ("_nm_per_rad", "N m/rad"),
    ("_nm_per_s", "N m/s"),
    ("_kg_m2", "kg m²"),
    ("_nm_s", "N m s"),
    ("_nm", "N m"),
    ("_rad", "rad"),
    ("_s", "s"),
)
ERRORS = (
    ("torque_mae", "torque, mean absolute error", "N m"),
    ("torque_rmse", "torque, root mean square error", "N m"),
    ("free_run_rmse", "yaw rate in free run, root mean square error", "rad/s"),
)
HEADLINES = {
    "none": "Nothing is missing that these recordings could show",
    "unexplained": "Something is missing that no effect of the catalogue explains",
}


def page(found: Trace, axis: Axis = YAW, made: Mapping[str, str] | None = None) -> str:
    """The whole document, in the words and units of an axis; `made` says what it was made of, and how."""

    def told(text: str) -> str:
        return said(axis, text)

    environment = Environment(
        loader=PackageLoader("viewer.report", "."), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    pictures = found.pictures
    environment.filters["told"] = told
    rate = pictures.depends["yaw_rate"]
    coefficients, driven = derivatives(found, axis)
    seen, flat = told_apart(pictures.depends, pictures.residual_before, pictures.residual_after)
    return environment.get_template("page.html.j2").render(
        found=found,
        headline=_headline(found),
        summary=told(_summary(found.error)),
        findings=[_finding(finding, axis) for finding in found.effects],
        errors=_error_rows(found.error, axis),
        trivial={name: number(errors["free_run_rmse"]) for name, errors in found.error["trivial"].items()},
        horizons=[
            (horizon, *(number(errors[name]) for name in ("before", "after", "hold", "zero")))
            for horizon, errors in found.error["horizons"].items()
        ],
        floor=number(found.error["floor"]["torque_rmse"]),
        validated_on=_validated_on(found),
        made=made or {},
        derivatives=[
            (each.symbol, number(each.value), _between(each.interval), told(each.unit)) for each in coefficients
        ],
        driven=[number(each) for each in driven],
        flat=[name.replace("_", " ") for name in flat],
        residual=Markup(residual_against(seen, pictures.residual_before, pictures.residual_after, axis)),
        free_run=Markup(free_runs(pictures.before, pictures.after, found.model.scale, axis)),
        damping=Markup(damping_curves(found.declared_model, found.model, rate[np.isfinite(rate)], axis)),
        split=Markup(torque_split(pictures.ledger, axis)),
        number=number,
        chance=chance,
        probability=probability,
    )


def _headline(found: Trace) -> str:
    if not found.beats_zero:
        return "The model predicts no better than a rate of zero"
    return HEADLINES.get(found.verdict) or f"The model lacks {_listed([f.effect for f in found.effects])}"


def _between(interval: tuple[float, float] | None) -> str:
    return "declared" if interval is None else f"{number(interval[0])} to {number(interval[1])}"


def number(value: float, sign: str = "") -> str:
    """Three significant digits, with a true minus sign; with `sign` "+", a plus before what is positive."""
    return f"{value:{sign}.3g}".replace("-", "−")


def probability(p_value: float) -> str:
    """A p-value for a table, three significant digits, never zero."""
    return chance(p_value, 3).removeprefix("= ").replace("-", "−")


def _listed(names: list[str]) -> str:
    plain = [name.replace("_", " ") for name in names]
    return plain[0] if len(plain) == 1 else f"{', '.join(plain[:-1])} and {plain[-1]}"


def _validated_on(found: Trace) -> str:
    if found.error["validated_on"] == "recordings":
        return "recordings that were not used for the fit"
    return "held-out pieces of the recordings, each predicted by a fit without it"


def _summary(error: Mapping[str, Any]) -> str:
    before, after = error["before"]["free_run_rmse"], error["after"]["free_run_rmse"]
    change = error["change"]["free_run_rmse"]
    said = (
        f"On unseen data the free-run error of the yaw rate is {number(before)} rad/s with the declared model and "
        f"{number(after)} rad/s with what was added"
    )
    if after == before:
        return f"On unseen data the free-run error of the yaw rate is {number(before)} rad/s. Nothing was added."
    certain = change["high"] < 0.0 or change["low"] > 0.0
    doubt = "" if certain else " This interval includes zero: the gain is not proven."
    return (
        f"{said}: {number(100.0 * (after / before - 1.0), '+')} % "
        f"(95 % interval of the change {number(change['low'])} to {number(change['high'])} rad/s).{doubt}"
    )


def _finding(finding: Finding, axis: Axis) -> dict[str, Any]:
    rows = []
    for name, value in finding.parameters.items():
        suffix, unit = next(((s, u) for s, u in SUFFIXES if name.endswith(s)), ("", ""))
        low, high = finding.interval.get(name, (float("nan"), float("nan")))
        plain = name.removesuffix(suffix).replace("_", " ")
        # a harmonic or a channel's mean is set, not fitted: it has no interval
        rows.append(
            (
                plain,
                number(value),
                "set, not fitted" if low == high else f"{number(low)} to {number(high)}",
                said(axis, unit),
            )
        )
    return {"finding": finding, "name": finding.effect.replace("_", " "), "rows": rows}


def _error_rows(error: Mapping[str, Any], axis: Axis) -> list[dict[str, str]]:
    rows = []
    for key, label, unit in ERRORS:
        change = error["change"].get(key)
        rows.append(
            {
                "label": said(axis, label),
                "unit": said(axis, unit),
                "before": number(error["before"][key]),
                "after": number(error["after"][key]),
                "change": number(change["estimate"]) if change else "",
                "interval": f"{number(change['low'])} to {number(change['high'])}" if change else "",
            }
        )
    return rows
