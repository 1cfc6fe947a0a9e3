"""Figures as the report prints them, and its templates."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from incsvr.plant.axes import Axis
from incsvr.plant.words import words_of


def number(value: float | None, sign: str = "") -> str:
    """Three significant digits, with a true minus sign; with `sign` "+", a plus before what is positive; a dash where
    there is no number."""
    if value is None or not math.isfinite(value):
        return "–"
    return f"{value:{sign}.3g}".replace("-", "−")


def between(interval: tuple[float, float] | None) -> str:
    """An interval; what was declared has none."""
    return "declared" if interval is None else f"{number(interval[0])} to {number(interval[1])}"


def capital(sentence: str) -> str:
    """A sentence that begins as one."""
    return sentence[:1].upper() + sentence[1:]


def rendered(template: str, axis: Axis, provenance: Mapping[str, str] | None, **values: Any) -> str:
    """A page of one of the report's templates, in an axis's words and units; `provenance` is what it was made of."""
    environment = Environment(
        loader=PackageLoader("viewer.report", "."), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    environment.globals |= {"words": words_of(axis), "number": number, "between": between}
    return environment.get_template(template).render(provenance=provenance or {}, **values)
