"""An engine's model as the value that live, forecasts and reports read, with a term for each effect."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from incsvr.model.factors import one_by_one
from incsvr.model.fitting import Fit
from incsvr.model.series import effort_of, values
from incsvr.model_trace.model import TABLE_RATES, Term, TracedModel
from incsvr.model_trace.thresholds import TABLED_RATE_QUANTILES
from incsvr.model_trace.vocabulary import contract_name, here, word_of
from incsvr.numerics import Array

AT_STAGES = {"dead": ("dead_zone", "shifted"), "limit": ("torque_saturation", "limit")}


def traced_model(
    model: Fit, effects: Sequence[str], inertia: float, begin: float, sigma: float, block: float, scale: float
) -> TracedModel:
    """The model as a TracedModel.

    Args:
        effects: the engine's names of those that the model has.
        inertia: declared.
        begin: the stamp at which the channel `time` is zero [s].
        sigma: deviation of what the model lacks over a block [N m].
        block, scale: [s].
    """
    (axis,) = model.structure.axes
    runs = model.problem.windows.runs
    low, high = (float(q) for q in np.quantile(values(runs, axis), TABLED_RATE_QUANTILES))
    sides = [np.linspace(min(low, -1e-6), 0.0, TABLE_RATES), np.linspace(0.0, max(high, 1e-6), TABLE_RATES)]
    rate = np.unique(np.concatenate(sides))
    end = max(float(run[axis][0][-1]) for run in runs)
    terms = [_term(model, name, inertia, begin) for name in effects]
    if f"mass:{axis}" in model.names and not any(term.effect == "inertia" for term in terms):
        terms.append(Term("inertia", "", (model.structure.inertia(model.theta, axis) - inertia,)))
    delayed = any(term.effect == "torque_delay" for term in terms)
    return TracedModel(
        inertia, rate, damping_of(model, rate), tuple(terms), sigma, block, scale, (begin, end),
        0.0 if delayed else model.theta.get(f"shift:{axis}", 0.0),
    )  # fmt: skip


def damping_of(model: Fit, rate: Array) -> Array:
    """d(r) of the model's own damping [N m]."""
    (axis,) = model.structure.axes
    found = np.zeros_like(rate)
    for row in model.structure.rows:
        if row.name.partition(":")[0] in ("linear", "quadratic", "bend"):
            part = row.parts[0]
            taken = one_by_one(part.one, {axis: rate}) * one_by_one(part.other, {axis: rate})
            found += model.theta[row.key] * taken
    return found


def _term(model: Fit, name: str, inertia: float, begin: float) -> Term:
    """The catalogue's term of an effect."""
    at, theta = here(model, name, inertia, begin), model.theta
    found, effect = dict(word_of(name).parameters(theta, at)), contract_name(name)
    kind = name.partition("@")[0].partition(":")[0]
    if kind in AT_STAGES:
        effect, variant = AT_STAGES[kind]
        return Term(effect, variant, (1.0,), tuple(found.values()))
    if kind == "exponent":
        return Term(effect, "", (1.0,), (model.problem.windows.largest(effort_of(at.axis)), found["exponent"]))
    if kind in ("heading_current", "wave"):
        size, phase = found["amplitude_nm"], found["phase_rad"]
        pair = (size * math.cos(phase), size * math.sin(phase))
        variant = f"{found['harmonic']:g}" if kind == "heading_current" else ""
        return Term(effect, variant, pair, () if variant else (found["period_s"],))
    if kind in ("coulomb", "coulomb_asymmetry"):
        creep = at.width(kind)
        both = theta[f"{kind}@{at.axis}"]
        uneven = kind == "coulomb_asymmetry"  # beside plain friction, which is a term of its own
        return Term(effect, "sharp" if uneven else "", (both, -both) if uneven else (both,), (creep,))
    return _plain_term(kind, effect, at.of, at.axis, inertia, found)


def _plain_term(kind: str, effect: str, of: str, axis: str, inertia: float, found: Mapping[str, float]) -> Term:
    """The term of an effect whose coefficients are its parameters, but for signs and origins."""
    if kind == "inertia":
        return Term(effect, "", (found["inertia_kg_m2"] - inertia,))
    if kind == "reverse":
        return Term(effect, "", (1.0 / found["reverse_efficiency"] - 1.0,))
    if kind == "lag":
        return Term(effect, "moment", (found["time_constant_s"],))
    if kind == "memory":
        return Term(effect, "linear", (-found["gain_nm_s"],), (found["time_constant_s"],))
    if kind == "tether":
        return Term(effect, "", (found["stiffness_nm_per_rad"], found["stiffness_nm_per_rad"] * found["neutral_rad"]),
                    (0.0,))  # fmt: skip
    if kind in ("drag_step", "thrust_step"):
        return Term(effect, "", (found["fraction"],), (found["at_s"],))
    if kind == "modulation":
        variant = "thrust" if of.endswith(":thrust") else "damping"
        return Term(effect, variant, (found["coefficient"],), (found["reference"],))
    if kind == "thrust_speed":
        return Term(effect, f"{of} falls", (found["coefficient"],), (0.0,))
    if kind in ("coriolis", "square"):
        own = axis if axis in effect.partition(":")[2].split("*") else ""
        return Term(effect, own, (found["coefficient"],))
    inner = (0.0,) if kind == "coupling" else ()
    return Term(effect, "", tuple(found.values()), inner)
