"""The model as CSV, a figure a row, and as JSON. Damping counts positive where it opposes."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator
from typing import Any

from incsvr.plant.axes import AXES
from incsvr.plant.terms import LINEAR, QUADRATIC, Term, mass_unit
from incsvr.vehicle import Parameter, Vehicle
from service.export.learned import Learned
from service.wire.json_text import json_text

HEADER = ("quantity", "estimate", "low", "high", "unit")
Row = tuple[str, Parameter | float, str]


def as_csv(model: Learned | Vehicle) -> str:
    """One figure a row, with its interval and unit."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(HEADER)
    for name, value, unit in _of_vehicle(model) if isinstance(model, Vehicle) else _of_learned(model):
        p = value if isinstance(value, Parameter) else Parameter(value, math.nan, math.nan)
        writer.writerow([name, repr(p.value), *("" if math.isnan(end) else repr(end) for end in (p.low, p.high)), unit])
    return out.getvalue()


def as_json(model: Learned | Vehicle) -> str:
    """Everything; of a learned axis also the curve with its uncertainty."""
    return json_text(model.to_dict() if isinstance(model, Vehicle) else _learned_dict(model), indent=2) + "\n"


def _of_vehicle(vehicle: Vehicle) -> Iterator[Row]:
    for (one, other), p in vehicle.mass.items():
        yield f"{one} inertia" if one == other else f"{one}-{other} inertia", p, mass_unit(one, other)
    yield from ((f"{term.axis} {term.name}", p, term.unit) for term, p in vehicle.terms.items())
    yield from ((f"{axis} thrust lag", p, "s") for axis, p in vehicle.lags.items())


def _of_learned(model: Learned) -> Iterator[Row]:
    axis = model.axis
    rate, effort = ("m/s", "N") if AXES[axis].along else ("rad/s", "N m")
    yield "N_r", model.linear, Term(axis, LINEAR).unit
    yield "N_r|r|", model.quadratic, Term(axis, QUADRATIC).unit.replace("²", "^2")
    yield "inertia", model.inertia, mass_unit(axis, axis).replace("²", "^2")
    yield "rate_low", float(model.rate[0]), rate
    yield "rate_high", float(model.rate[-1]), rate
    yield "form_error_rms", model.form_error, effort
    if model.noise is not None:
        yield "noise", model.noise, effort
    # The unit of a traced parameter stands in its name.
    for effect in model.effects:
        yield from ((f"{effect.name}.{name}", p, "") for name, p in effect.parameters.items())


def _learned_dict(model: Learned) -> dict[str, Any]:
    def plain(p: Parameter) -> dict[str, float]:
        return {"estimate": p.value, "low": p.low, "high": p.high}

    return {
        "source": model.source,
        "equation": "I dr/dt + N_r r + N_r|r| r|r| = torque",
        "coefficients": {"N_r": plain(model.linear), "N_r|r|": plain(model.quadratic)},
        "inertia": plain(model.inertia),
        "valid": [float(model.rate[0]), float(model.rate[-1])],
        "form_error_rms": model.form_error,
        "noise": model.noise,
        "effects": [
            {
                "effect": effect.name,
                "parameters": {name: plain(p) for name, p in effect.parameters.items()},
                "cannot_tell_from": list(effect.cannot_tell_from),
            }
            for effect in model.effects
        ],
        "curve": {
            "rate": model.rate.tolist(),
            "damping": model.damping.tolist(),
            "sigma": None if model.sigma is None else model.sigma.tolist(),
            "doubt": None if model.doubt is None else model.doubt.tolist(),
        },
    }
