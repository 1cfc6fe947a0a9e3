"""The vehicle file: the identified model of a whole vehicle as YAML, written and read."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from incsvr.errors import BadInput
from service.config.core_yaml import parse
from service.config.vehicle_entries import check_entries
from service.wire.json_text import json_text

if TYPE_CHECKING:
    from incsvr.vehicle import Vehicle

MARK = "# The model of a whole vehicle, written by `incsvr identify`"
"""The words by which a vehicle file is recognised."""
HEAD = f"""\
{MARK}: M dν/dt + C(ν) ν + Σ c φ(ν, τ, η) = τ.
# ν = surge, sway, heave [m/s], roll, pitch and yaw rate [rad/s]; τ the efforts [N], [N m]; SI units throughout.
# Each parameter has its value, the ends low and high of its interval of 95 %, and its origin: estimated, declared,
# assumed (its axis has no actuator), not excited (the interval is wider than the axis's usual effort), or bound
# reached (the search for an inertia ended at its edge: the recordings do not determine it).
# C(ν) follows from the mass matrix. The terms φ: linear ν; quadratic ν|ν|; cross:j ν_j; product:j*k ν_j ν_k;
# square:j ν_j²; cross_size:j*k |ν_j| ν_k; effort:a −τ_a; inflow:j τ|ν_j|; reverse τ where τ < 0; bias 1;
# righting sin φ cos θ (roll), sin θ (pitch); weight: minus the downward direction.
# doubts: why predictions, parameters or intervals may be wrong; an export repeats them.
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
