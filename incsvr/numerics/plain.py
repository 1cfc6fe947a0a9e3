"""Records as plain data for a file, and back, by the types of their fields: exact to the bit through JSON."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from functools import cache
from types import NoneType, UnionType
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

Record = TypeVar("Record")


def to_plain(value: Any) -> Any:
    """Dictionaries, lists, numbers and texts: a record by its own `to_dict`, else by its fields."""
    if hasattr(value, "to_dict"):
        return value.to_dict()
    if dataclasses.is_dataclass(value):
        return fields_to_plain(value)
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, tuple):
        return [to_plain(each) for each in value]
    if isinstance(value, Mapping):
        return {name: or_none(each) if isinstance(each, np.ndarray) else to_plain(each) for name, each in value.items()}
    return value


def or_none(values: NDArray[np.float64]) -> tuple[float | None, ...]:
    """Values of a channel, None where it was not sampled, or filtered beyond all floats."""
    return tuple(value if math.isfinite(value) else None for value in values.tolist())


def fields_to_plain(record: Any) -> dict[str, Any]:
    """The fields of a record by their names."""
    kind: Any = type(record)
    return {name: to_plain(getattr(record, name)) for name in _types(kind)}


def from_plain(kind: type[Record], data: Any) -> Record:
    """The record of this kind that was given to `to_plain`.

    Raises:
        Exception: of any kind, where it is none.
    """
    own = getattr(kind, "from_dict", None)
    return fields_from_plain(kind, data) if own is None else own(data)


def fields_from_plain(kind: type[Record], data: Any) -> Record:
    """The record with these fields; those that are missing have their defaults."""
    of_kind: Any = kind
    types = _types(of_kind)
    if not isinstance(data, Mapping):  # as earlier forms list them
        data = dict(zip(types, data, strict=True))
    return kind(**{name: _value(of, data[name]) for name, of in types.items() if name in data})


@cache
def _types(kind: Any) -> Mapping[str, Any]:
    hints = get_type_hints(kind)
    return {each.name: hints[each.name] for each in dataclasses.fields(kind)}


def _value(kind: Any, data: Any) -> Any:
    origin, parts = get_origin(kind), get_args(kind)
    if origin is UnionType:
        return None if data is None else _value(next(part for part in parts if part is not NoneType), data)
    if origin is np.ndarray:
        return np.array(data, dtype=get_args(parts[1])[0])
    if origin is Mapping:
        return {name: _value(parts[1], each) for name, each in data.items()}
    if origin is tuple:
        return tuple(_value(parts[0], each) for each in data)
    return from_plain(kind, data) if isinstance(kind, type) and dataclasses.is_dataclass(kind) else data
