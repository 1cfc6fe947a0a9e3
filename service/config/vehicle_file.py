"""The vehicle file: the identified model of a whole vehicle as YAML, written and read."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    StrictFloat,
    StrictStr,
    ValidationError,
    model_validator,
)

from incsvr.errors import BadInput
from incsvr.plant.axes import AXES, VELOCITIES
from incsvr.plant.mass_and_coriolis import mass_matrix
from incsvr.plant.terms import mass_unit, stage_unit, term
from service.config.core_yaml import parse, quote
from service.wire.json_text import json_text

if TYPE_CHECKING:
    from incsvr.vehicle import Vehicle


_AXIS, _VELOCITY = f"({'|'.join(AXES)})", f"({'|'.join(VELOCITIES)})"
_TERM = re.compile(
    rf"linear|quadratic|reverse|bias|weight|righting|advance|(cross|square|inflow):{_VELOCITY}|effort:{_AXIS}"
    r"|(coulomb|coulomb_asymmetry|bend):(0|[1-9]\d*)?(\.\d+)?([eE][-+]?\d+)?"
    rf"|(product|cross_size):{_VELOCITY}\*{_VELOCITY}"
)
"""Names of the terms, which the head of a vehicle file explains."""
DAMPING = ("linear", "quadratic")
"""Terms that may not be negative."""
OF_AXES = {"righting": ("roll", "pitch"), "weight": ("surge", "sway", "heave")}
"""Terms that only these axes can have."""

Axis = Literal["surge", "sway", "heave", "roll", "pitch", "yaw"]


class Part(BaseModel):
    """A part of a vehicle file: unknown names are refused, because they are misspelt ones."""

    model_config = ConfigDict(frozen=True, allow_inf_nan=False, extra="forbid")


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


class Share(Entry):
    """A parameter that must be positive."""

    value: StrictFloat = Field(gt=0.0)


class Thrust(Part):
    """What the actuators of an axis make of its effort, in this order: each stage may be left out."""

    exponent: Share | None = None
    full_effort: Share | None = None
    dead_zone: TimeConstant | None = None
    limit: Share | None = None
    reverse: TimeConstant | None = None
    rotor_lag_s: TimeConstant | None = None
    delay_s: TimeConstant | None = None

    @model_validator(mode="after")
    def _of_a_curve(self) -> Self:
        if (self.exponent is None) != (self.full_effort is None):
            raise ValueError("exponent and full_effort belong together: give both, or none")
        return self


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
    thrust: dict[Axis, Thrust] = Field(default={})
    fastest: dict[Axis, Annotated[StrictFloat, Field(ge=0.0, le=50.0)]]
    learners: dict[StrictStr, dict[StrictStr, Any]] = Field(default={})
    doubts: tuple[Annotated[StrictStr, AfterValidator(_name)], ...] = ()
    beaten_by: Literal["", "zero", "hold"] = ""

    @model_validator(mode="after")
    def _of_its_axes(self) -> Self:
        for key, named in (("driven", self.driven), ("terms", self.terms), ("thrust", self.thrust)):
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
        for axis, thrust in self.thrust.items():
            if thrust.rotor_lag_s is not None and axis in self.thrust_lag_s:
                raise ValueError(f"{axis} lags twice, by thrust_lag_s and by rotor_lag_s, two shapes of one: keep one")
            for name, stage in thrust:
                if stage is not None:
                    stage.in_unit(f"thrust.{axis}.{name}", stage_unit(axis, name))
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


MARK = "# The model of a whole vehicle, written by `incsvr identify`"
"""The words by which a vehicle file is recognised."""
HEAD = f"""\
{MARK}: M dν/dt + C(ν) ν + Σ c φ(ν, τ, η) = τ.
# ν = surge, sway, heave [m/s], roll, pitch and yaw rate [rad/s]; τ the efforts [N], [N m]; SI units throughout.
# Each parameter has its value, the ends low and high of its interval of 95 %, and its origin: estimated, declared,
# assumed (its axis has no actuator), not excited (the interval is wider than the axis's usual effort), or bound
# reached (the search for an inertia ended at its edge: the recordings do not determine it).
# C(ν) follows from the mass matrix. The terms φ: linear ν; quadratic ν|ν|; cross:j ν_j; product:j*k ν_j ν_k;
# square:j ν_j²; cross_size:j*k |ν_j| ν_k; effort:a −τ_a; inflow:j τ|ν_j|; advance ν√|τ|; reverse τ where τ < 0;
# bias 1; coulomb:w tanh(ν/w); coulomb_asymmetry:w tanh²(ν/w); bend:w the part of ν beyond ± w;
# righting sin φ cos θ (roll), sin θ (pitch); weight: minus the downward direction.
# thrust: stages that an effort passes before its lag, in this order: exponent p, u → u₀ (u/u₀)ᵖ with u₀ the
# full_effort; dead_zone [N], [N m]; limit; reverse, the share that thrust astern has of thrust ahead; delay_s; and
# rotor_lag_s, in place of a lag of the thrust: the rotors' speed n lags, T dn/dt + n = √u, and the thrust is n|n|.
# doubts: why predictions, parameters or intervals may be wrong; an export repeats them.
# beaten_by: zero or hold, where no motion, or the first velocity kept, predicts unseen data better than the model.
# learners: what `incsvr serve --vehicle FILE` learns, in the names of config.yaml; change it as you like.
"""
MAX_BYTES = 1_000_000
"""Largest vehicle file [bytes]: a model takes some 10 kB."""


def write_vehicle(path: Path, vehicle: Vehicle) -> None:
    """Writes a vehicle file, from which `read_vehicle` gives the same numbers to the last bit."""
    from service.config.vehicle_learners import learners_of  # what learners are made of is not needed to read one

    path.write_text(
        HEAD + "\n".join(_lines({**vehicle.to_dict(), "learners": learners_of(vehicle)}, "")) + "\n", encoding="utf-8"
    )


def read_vehicle(path: Path) -> Vehicle:
    """The vehicle in a file.

    Raises:
        BadInput: naming the file, what is wrong, and the cure.
    """
    # Loaded where it is needed alone: what identifies vehicles brings 60 MB with it, which no learner needs.
    from incsvr.vehicle import Vehicle

    return Vehicle.from_dict(read_values(path))


def learners_in(path: Path) -> Mapping[str, Any]:
    """The section `learners` of a vehicle file.

    Raises:
        BadInput: there is none, or as in `read_values`.
    """
    values = read_values(path)
    if not values["driven"]:
        raise BadInput(
            f"{path}: no axis of this vehicle has an actuator, so there is no damping to learn; identify it from a "
            "log that holds the efforts"
        )
    if not values.get("learners"):
        raise BadInput(f"{path}: it has no section learners; write it anew with `incsvr identify`")
    return dict(values["learners"])


def read_values(path: Path) -> Mapping[str, Any]:
    """The plain data in a vehicle file, checked.

    Raises:
        BadInput: naming the file, what is wrong, and the cure.
    """
    try:
        if path.stat().st_size > MAX_BYTES:
            raise BadInput(f"{path}: this is no vehicle file; `incsvr identify LOG --write FILE` writes one")
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise BadInput(f"{path}: there is no such file; `incsvr identify LOG --write {path}` writes one") from None
    except (OSError, UnicodeDecodeError):
        raise BadInput(f"{path}: cannot be read as text; give a file that `incsvr identify --write` wrote") from None
    values = parse(text, str(path)).value
    form = values.get("vehicle_file") if isinstance(values, dict) else None
    if type(form) is int and form > 1:
        raise BadInput(f"{path}: its form, vehicle_file: {form}, is newer than 1, which is read here; update incsvr")
    if not isinstance(values, dict) or type(form) is not int or form != 1:
        raise BadInput(f"{path}: this is no vehicle file; `incsvr identify LOG --write FILE` writes one")
    try:
        check_entries(values)
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from None
    return values


def _lines(values: Mapping[str, Any], indent: str) -> list[str]:
    """The lines of a mapping; a mapping of plain values stands in one line."""
    found = []
    for key, value in values.items():
        name = f"{indent}{_text(str(key))}"
        if isinstance(value, Mapping) and any(isinstance(inner, Mapping) for inner in value.values()):
            found += [f"{name}:", *_lines(value, indent + "  ")]
        elif isinstance(value, Mapping):
            inside = ", ".join(f"{_text(str(k))}: {_plain(v)}" for k, v in value.items())
            found.append(f"{name}: {{{inside}}}")
        elif isinstance(value, list) and any(" " in str(each) for each in value):
            found += [f"{name}:", *(f"{indent}  - {_plain(each)}" for each in value)]
        else:
            found.append(f"{name}: {_plain(value)}")
    return found


def _plain(value: Any) -> str:
    if isinstance(value, list):
        return "[" + ", ".join(_plain(each) for each in value) + "]"
    if isinstance(value, float):
        return repr(value) if value == value and abs(value) != float("inf") else "null"
    return str(value) if isinstance(value, int) else _text(str(value))


def _text(text: str) -> str:
    """A text as YAML reads it back: bare where it is a plain word, else in quotes."""
    return text if text.isidentifier() and parse(text, "").value == text else json_text(text)
