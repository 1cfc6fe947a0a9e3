"""The entries of a vehicle file, checked before any number is used: people edit these files by hand."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import AfterValidator, ConfigDict, Field, StrictFloat, StrictStr, ValidationError, model_validator

from incsvr.errors import BadInput
from incsvr.plant.axes import AXES, VELOCITIES
from incsvr.plant.mass_and_coriolis import mass_matrix
from incsvr.plant.terms import mass_unit, term
from service.config.core_yaml import quote
from service.wire.form import Form

_AXIS, _VELOCITY = f"({'|'.join(AXES)})", f"({'|'.join(VELOCITIES)})"
_TERM = re.compile(
    rf"linear|quadratic|reverse|bias|weight|righting|(cross|square|inflow):{_VELOCITY}|effort:{_AXIS}"
    rf"|(product|cross_size):{_VELOCITY}\*{_VELOCITY}"
)
"""Names of the terms, which the head of a vehicle file explains."""
DAMPING = ("linear", "quadratic")
"""Terms that may not be negative."""
OF_AXES = {"righting": ("roll", "pitch"), "weight": ("surge", "sway", "heave")}
"""Terms that only these axes can have."""

Axis = Literal["surge", "sway", "heave", "roll", "pitch", "yaw"]


class Part(Form):
    """A part of a vehicle file: unknown names are refused, because they are misspelt ones."""

    model_config = ConfigDict(extra="forbid")


class Entry(Part):
    """A parameter; other fields than its value may be left out."""

    value: StrictFloat
    low: StrictFloat | None = None
    high: StrictFloat | None = None
    origin: Literal["estimated", "declared", "assumed", "not excited", "bound reached"] | None = None
    unit: StrictStr | None = None

    @model_validator(mode="after")
    def _low_is_below_high(self) -> Self:
        if self.low is not None and self.high is not None and self.low > self.high:
            raise ValueError(f"low ({self.low:g}) is above high ({self.high:g})")
        return self

    def in_unit(self, place: str, unit: str) -> None:
        """Refuses another unit than that in which the number counts."""
        if self.unit not in (None, unit):
            raise ValueError(f"{place} is in {quote(self.unit or '')}; convert it to {unit}")


class TimeConstant(Entry):
    """A parameter that may not be negative."""

    value: StrictFloat = Field(ge=0.0)


def is_name(text: str) -> bool:
    """Whether a text can name a vehicle: one line that prints."""
    return bool(text.strip()) and text.isprintable()


def _name(text: str) -> str:
    if not is_name(text):
        raise ValueError("a name is one line of text")
    return text


class Entries(Part):
    """All that a vehicle file must hold."""

    vehicle_file: Literal[1]
    name: Annotated[StrictStr, AfterValidator(_name)]
    axes: list[Axis] = Field(min_length=1)
    driven: list[Axis]
    mass_matrix: dict[StrictStr, Entry]
    terms: dict[Axis, dict[StrictStr, Entry]]
    thrust_lag_s: dict[Axis, TimeConstant]
    fastest: dict[Axis, Annotated[StrictFloat, Field(ge=0.0, le=50.0)]]
    learners: dict[StrictStr, dict[StrictStr, Any]] = Field(default={})
    doubts: tuple[Annotated[StrictStr, AfterValidator(_name)], ...] = ()

    @model_validator(mode="after")
    def _of_its_axes(self) -> Self:
        for key, named in (("driven", self.driven), ("terms", self.terms)):
            for axis in named:
                if axis not in self.axes:
                    raise ValueError(f"{key} names {axis}, which is not among axes")
        missing = [axis for axis in AXES if axis not in self.fastest]
        if missing:
            raise ValueError(f"fastest lacks {missing[0]}")
        still = [axis for axis in self.axes if self.fastest[axis] == 0.0]
        if still:
            raise ValueError(f"fastest.{still[0]} is 0; it is the fastest velocity for which the model holds")
        return self

    @model_validator(mode="after")
    def _of_known_terms(self) -> Self:
        for axis, terms in self.terms.items():
            for name, entry in terms.items():
                if _TERM.fullmatch(name) is None or axis not in OF_AXES.get(name, AXES):
                    raise ValueError(f"{axis} has no term {quote(name)}; the head of a vehicle file lists the terms")
                if name in DAMPING and entry.value < 0.0:
                    raise ValueError(f"terms.{axis}.{name} is negative; damping that opposes the motion is positive")
                entry.in_unit(f"terms.{axis}.{name}", term(axis, name).unit)
        for axis, lag in self.thrust_lag_s.items():
            lag.in_unit(f"thrust_lag_s.{axis}", "s")
        return self

    @model_validator(mode="after")
    def _of_a_body(self) -> Self:
        names, matrix = list(AXES), np.zeros((6, 6))
        for key, entry in self.mass_matrix.items():
            pair = key.split(",")
            if len(pair) != 2 or not set(pair) <= set(names):
                raise ValueError(
                    f"mass_matrix has no entry {quote(key)}; an entry is named by two axes, as surge,pitch"
                )
            row, column = (names.index(axis) for axis in pair)
            entry.in_unit(f"mass_matrix.{key}", mass_unit(*pair))
            if row != column and f"{pair[1]},{pair[0]}" in self.mass_matrix:
                raise ValueError(f"mass_matrix holds both {key} and {pair[1]},{pair[0]}; it is symmetric: keep one")
            matrix[row, column] = matrix[column, row] = entry.value
        for axis in self.axes:
            if not matrix[names.index(axis), names.index(axis)] > 0.0:
                raise ValueError(f"mass_matrix needs {axis},{axis} above 0")
        rows = [names.index(axis) for axis in self.axes]
        scale = 1.0 / np.sqrt(np.diag(matrix)[rows])
        if not float(np.linalg.eigvalsh(matrix[np.ix_(rows, rows)] * np.outer(scale, scale))[0]) > 0.0:
            raise ValueError("mass_matrix belongs to no body: an entry off its diagonal is too large")
        mass_matrix(matrix.ravel().tolist())
        return self


def check_entries(values: Mapping[str, Any]) -> None:
    """Refuses entries that are missing, of no vehicle, or no numbers.

    Raises:
        BadInput: naming the entry, what it must be, and the cure.
    """
    try:
        Entries.model_validate(values)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(str(part) for part in first["loc"] if part != "[key]")
        reason = first["msg"].removeprefix("Value error, ")
        if first["type"] == "extra_forbidden":
            reason = "a vehicle file has no such entry"
        where = f"{quote(place)}: " if place else ""
        raise BadInput(
            f"the vehicle file is incomplete or damaged: {where}{reason}; correct it, or write it anew with `incsvr "
            "identify`"
        ) from None
