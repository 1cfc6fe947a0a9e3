"""The value that live, forecasts and reports read, from a fit of the engine."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from incsvr.model.factors import one_by_one
from incsvr.model.fitting import Fit
from incsvr.model.rows import Row
from incsvr.model.series import effort_of, values
from incsvr.numerics import Array
from incsvr.tracing.model import TABLE_RATES, Effect, TracedModel
from incsvr.tracing.vocabulary import contract_name

DAMPING = ("linear", "quadratic", "bend")
"""Rows of an axis's own damping, without what is behind their colon."""


def traced_model(
    model: Fit,
    effects: Mapping[str, Collection[str]],
    inertia: float,
    begin: float,
    sigma: float,
    block: float,
    scale: float,
    learned: tuple[float, float] = (0.002, 0.998),  # quantiles of the rates between which the damping was learned
) -> TracedModel:
    """The model as a TracedModel; an inertia that is free in the fit is an effect.

    Args:
        effects: by the engine's names of those that the model has, the parameters that each brought.
        inertia: declared.
        begin: the stamp at which the channel `time` is zero [s].
        sigma: deviation of what the model lacks over a block [N m].
        block, scale: [s].
    """
    (axis,) = model.structure.axes
    runs = model.problem.windows.runs
    low, high = (float(q) for q in np.quantile(values(runs, axis), learned))
    sides = [np.linspace(min(low, -1e-6), 0.0, TABLE_RATES), np.linspace(0.0, max(high, 1e-6), TABLE_RATES)]
    rate = np.unique(np.concatenate(sides))
    end = max(float(run[axis][0][-1]) for run in runs)
    mass = f"mass:{axis}"
    if mass in model.names and not any(mass in keys for keys in effects.values()):
        effects = {**effects, f"inertia@{axis}": (mass,)}
    found = tuple(
        Effect(
            contract_name(name),
            {key: float(model.theta[key]) for key in keys},
            tuple(Row(row.name, row.parts, follows=row.follows) for row in model.structure.rows if row.key in keys),
        )
        for name, keys in effects.items()
    )
    top = model.problem.windows.largest(effort_of(axis))
    return TracedModel(inertia, rate, damping_of(model, rate), found, sigma, block, scale, (begin, end), axis, top)


def damping_of(model: Fit, rate: Array) -> Array:
    """d(r) of the model's own damping [N m]."""
    (axis,) = model.structure.axes
    found = np.zeros_like(rate)
    for row in model.structure.rows:
        if row.name.partition(":")[0] in DAMPING:
            part = row.parts[0]
            taken = one_by_one(part.one, {axis: rate}) * one_by_one(part.other, {axis: rate})
            found += model.theta[row.key] * taken
    return found
