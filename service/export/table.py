"""The model as CSV, a figure a row, and as JSON, with the curve itself."""

from __future__ import annotations

import csv
import io
from typing import Any

from service.export.damping_model import DampingModel, Value

HEADER = ("quantity", "estimate", "low", "high", "unit")


def rows(model: DampingModel) -> list[tuple[str, Value, str]]:
    """Name, figure with its interval, unit. Damping counts positive where it opposes."""
    low, high = model.valid
    found = [
        ("N_r", model.linear, "N m s/rad"),
        ("N_r|r|", model.quadratic, "N m s^2/rad^2"),
        ("inertia", model.inertia, "kg m^2"),
        ("rate_low", Value(low), "rad/s"),
        ("rate_high", Value(high), "rad/s"),
        ("form_error_rms", Value(model.form_error), "N m"),
    ]
    if model.noise is not None:
        found.append(("noise", Value(model.noise), "N m"))
    # The unit of a traced parameter stands in its name.
    return found + [
        (f"{effect.name}.{name}", value, "") for effect in model.effects for name, value in effect.parameters.items()
    ]


def as_csv(model: DampingModel) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(HEADER)
    for name, value, unit in rows(model):
        ends = ["" if end is None else repr(end) for end in (value.low, value.high)]
        writer.writerow([name, repr(value.estimate), *ends, unit])
    return out.getvalue()


def as_json(model: DampingModel) -> dict[str, Any]:
    low, high = model.valid
    curve = model.curve
    return {
        "source": model.source,
        "equation": "I dr/dt + N_r r + N_r|r| r|r| = torque",
        "coefficients": {"N_r": _plain(model.linear), "N_r|r|": _plain(model.quadratic)},
        "inertia": _plain(model.inertia),
        "valid": [low, high],
        "form_error_rms": model.form_error,
        "noise": model.noise,
        "effects": [
            {
                "effect": effect.name,
                "parameters": {name: _plain(value) for name, value in effect.parameters.items()},
                "cannot_tell_from": list(effect.cannot_tell_from),
            }
            for effect in model.effects
        ],
        "curve": {
            "rate": curve.rate.tolist(),
            "damping": curve.damping.tolist(),
            "sigma": None if curve.sigma is None else curve.sigma.tolist(),
            "doubt": None if curve.doubt is None else curve.doubt.tolist(),
        },
    }


def _plain(value: Value) -> dict[str, float | None]:
    return {"estimate": value.estimate, "low": value.low, "high": value.high}
