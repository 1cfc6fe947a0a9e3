"""A declared inertia that is wrong by a factor: traced with the one that the motion shows, and told of the declared."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from incsvr.effects import Term
from incsvr.effects.inertia import Inertia
from incsvr.tracing.findings import Finding, Trace
from incsvr.tracing.output_error import Identified
from incsvr.tracing.run import Run
from incsvr.tracing.sentences import sentence
from incsvr.tracing.skill import horizons, proven
from incsvr.tracing.statistics import Change, change_of_rms
from incsvr.tracing.weak.hypothesis import nothing
from incsvr.tracing.weak.modelled import model_of
from incsvr.tracing.weak.noise import torque_scatter
from incsvr.tracing.weak.posing import pose
from incsvr.tracing.weak.validation import Validation
from incsvr.tracing.weak.validation_errors import sample_errors
from incsvr.tracing.weak.weak_trace import weak_trace

Array = NDArray[np.float64]

SEPARATE = "no yaw recording tells a larger inertia from weaker thrust: pull at a bollard, or swing the vehicle in air"

ALIGNED = 4000
"""Instants to which the errors of the two models are put side by side."""


def traced_anew(
    runs: Sequence[Run],
    declared: float,
    shown: Identified,
    validate: Sequence[Run] | None,
    names: Sequence[str],
    ignored: dict[str, str],
    excluded: Mapping[str, str],
    holds: bool | None,
) -> Trace:
    """What the declared model lacks where its inertia is wrong by a factor; the arguments as `weak_trace`.

    Everything else is found with the inertia that is `shown`; errors before are those of the declared model.
    """
    found = weak_trace(runs, shown.inertia, validate, names, ignored, excluded, holds)
    problem = pose(runs, declared, names)
    base = nothing(problem)
    before = Validation.of(problem, validate).errors(base)
    mae, rmse = sample_errors(before.torque, torque_scatter(runs, problem.blocks.period))
    after = found.pictures.after
    change = {
        "torque_rmse": _change(before.torque, after.torque).to_dict(),
        "free_run_rmse": _change(before.free_run, after.free_run).to_dict(),
    }
    errors = {"torque_mae": mae, "torque_rmse": rmse, "free_run_rmse": before.free_run_rmse()}
    ahead = horizons(before.ahead, after.ahead)
    error = {**found.error, "before": errors, "change": change, "horizons": ahead}
    inertia = next((f.parameters["inertia_kg_m2"] for f in found.effects if f.effect == "inertia"), shown.inertia)
    ledger = {name: part * (declared / shown.inertia) for name, part in found.pictures.ledger.items() if "decl" in name}
    rest = {name: part for name, part in found.pictures.ledger.items() if name not in (*ledger, "inertia")}
    of_inertia = [part for name, part in found.pictures.ledger.items() if name == "inertia" or name in ledger]
    total: Array = np.sum(of_inertia, axis=0)
    ledger |= {"damping": rest.pop("damping"), "inertia": total - sum(ledger.values()), **rest}
    return replace(
        found,
        inertia=declared,
        verdict="effects",
        effects=tuple(_findings(found, declared, shown, inertia, (rmse, found.error))),
        error=error,
        notes=(_note(declared, inertia), *found.notes),
        declared_model=model_of(problem, base),
        model=replace(
            found.model,
            inertia=declared,
            terms=(
                Term("inertia", "", (inertia - declared,)),
                *(term for term in found.model.terms if term.effect != "inertia"),
            ),
        ),
        pictures=replace(found.pictures, before=before, ledger=ledger),
        proven=proven(error, found.loop == "closed"),
    )


def _note(declared: float, inertia: float) -> str:
    factor = max(inertia / declared, declared / inertia)
    return (
        f"the declared inertia of {declared:.4g} kg m² is wrong by a factor of {factor:.2g}; all else is told with the "
        f"{inertia:.4g} kg m² that the free runs show"
    )


def _findings(
    found: Trace, declared: float, shown: Identified, inertia: float, errors: tuple[float, dict[str, dict[str, float]]]
) -> list[Finding]:
    """The inertia first, then the others with what refers to the inertia in parts of the declared one."""
    before, traced = errors
    squares = before**2, traced["before"]["torque_rmse"] ** 2, traced["after"]["torque_rmse"] ** 2
    explained_part = float(np.clip((squares[0] - squares[1]) / max(squares[0] - squares[2], 1e-300), 0.0, 1.0))
    own = next((each for each in found.effects if each.effect == "inertia"), None)
    interval = own.interval if own else {"inertia_kg_m2": (shown.low, shown.high)}
    deviation = np.log(shown.high / shown.low) / (2.0 * 1.96)
    effect, parameters = Inertia(), {"inertia_kg_m2": inertia}
    first = Finding(
        effect="inertia",
        channels=(),
        parameters=parameters,
        interval=interval,
        p_value=float(2.0 * norm.sf(abs(np.log(shown.inertia / declared)) / max(deviation, 1e-9))),
        share=explained_part,
        cannot_tell_from=("thrust_efficiency",),
        next_manoeuvre=SEPARATE,
        sentence=sentence(effect, parameters, interval, explained_part),
    )
    others = []
    known = {effect.name: effect for effect in found.model.effects()}
    for each in found.effects:
        if each.effect == "inertia":
            continue
        scale = shown.inertia / declared
        values = {name: value * (scale if name == "ratio" else 1.0) for name, value in each.parameters.items()}
        ends = {
            name: (low * scale, high * scale) if name == "ratio" else (low, high)
            for name, (low, high) in each.interval.items()
        }
        part = each.share * (1.0 - explained_part)
        words = sentence(known[each.effect], values, ends, part)
        others.append(replace(each, parameters=values, interval=ends, share=part, sentence=words))
    return [first, *others]


def _change(before: Sequence[Array], after: Sequence[Array]) -> Change:
    """Of the errors of two models, whose instants may differ: the same recordings in the same order."""
    place = (np.arange(ALIGNED) + 0.5) / ALIGNED
    sides = []
    for errors in (before, after):
        joined = np.concatenate([*errors])
        size = np.interp(place * joined.size, np.arange(joined.size) + 0.5, joined**2)
        sides.append(np.sqrt(size * (np.mean(joined**2) / max(float(np.mean(size)), 1e-300))))
    return change_of_rms([sides[0]], [sides[1]], ALIGNED // 40)
