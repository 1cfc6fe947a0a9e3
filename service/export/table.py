"""As CSV, a figure a row, and as JSON, with the curve itself."""

from __future__ import annotations

import csv
import io
from typing import Any

from service.export.learned import Learned, Value

HEADER = ("quantity", "estimate", "low", "high", "unit")


def rows(learned: Learned) -> list[tuple[str, Value, str]]:
    """Name, figure with its interval, unit. Damping counts positive where it opposes."""
    low, high = learned.valid
    found = [
        ("N_r", learned.linear, "N m s/rad"),
        ("N_r|r|", learned.quadratic, "N m s^2/rad^2"),
        ("inertia", learned.inertia, "kg m^2"),
        ("rate_low", Value(low), "rad/s"),
        ("rate_high", Value(high), "rad/s"),
        ("form_error_rms", Value(learned.form_error), "N m"),
    ]
    if learned.noise is not None:
        found.append(("sample_noise", Value(learned.noise), "N m"))
    # The unit of a traced parameter stands in its name.
    return found + [
        (f"{effect.name}.{name}", value, "") for effect in learned.effects for name, value in effect.parameters.items()
    ]


def as_csv(learned: Learned) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(HEADER)
    for name, value, unit in rows(learned):
        ends = ["" if end is None else repr(end) for end in (value.low, value.high)]
        writer.writerow([name, repr(value.estimate), *ends, unit])
    return out.getvalue()


def as_json(learned: Learned) -> dict[str, Any]:
    low, high = learned.valid
    curve = learned.curve
    return {
        "source": learned.source,
        "equation": "I dr/dt + N_r r + N_r|r| r|r| = torque",
        "coefficients": {"N_r": _plain(learned.linear), "N_r|r|": _plain(learned.quadratic)},
        "inertia": _plain(learned.inertia),
        "valid": [low, high],
        "form_error_rms": learned.form_error,
        "sample_noise": learned.noise,
        "effects": [
            {
                "effect": effect.name,
                "parameters": {name: _plain(value) for name, value in effect.parameters.items()},
                "cannot_tell_from": list(effect.cannot_tell_from),
            }
            for effect in learned.effects
        ],
        "curve": {
            "rate": curve.rate.tolist(),
            "damping": curve.damping.tolist(),
            "sigma": None if curve.sigma is None else curve.sigma.tolist(),
        },
    }


def _plain(value: Value) -> dict[str, float | None]:
    return {"estimate": value.estimate, "low": value.low, "high": value.high}
