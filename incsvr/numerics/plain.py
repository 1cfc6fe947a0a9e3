"""Records as plain data for a file or the bus, and back, by their type hints: exact to the bit through JSON."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Callable, Mapping
from functools import cache, partial
from types import NoneType, UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from incsvr.errors import BadInput

Record = TypeVar("Record")
UNLESS_EMPTY = {"unless_empty": True}
"""The metadata of a field that is not written where it is empty."""
_BARE = frozenset({float, int, str, bool, NoneType})
"""Kinds that are plain data as they are."""


class NotOfKind(BadInput):
    """Plain data that are no such record: where, such as support.rate.3, and what should be there."""

    def __init__(self, reason: str, *place: str) -> None:
        super().__init__(f"{'.'.join(place)}: {reason}" if place else reason)
        self.reason, self.place = reason, place

    def below(self, name: object) -> NotOfKind:
        """The error of the record that holds this one under a name: the place begins with that name."""
        return NotOfKind(self.reason, str(name), *self.place)


def to_plain(value: Any) -> Any:
    """Dictionaries, lists, numbers and texts: a record by its own `to_dict`, else by its fields."""
    if hasattr(value, "to_dict"):
        return value.to_dict()
    if dataclasses.is_dataclass(value):
        return fields_to_plain(value)
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, tuple):
        return list(value) if all(type(each) in _BARE for each in value) else [to_plain(each) for each in value]
    if isinstance(value, frozenset):
        return sorted(value)
    if isinstance(value, Mapping):
        return {
            name: list(or_none(each)) if isinstance(each, np.ndarray) else to_plain(each)
            for name, each in value.items()
        }
    return value


def or_none(values: NDArray[np.float64]) -> tuple[float | None, ...]:
    """Values of a channel, None where it was not sampled, or filtered beyond all floats."""
    return tuple(value if math.isfinite(value) else None for value in values.tolist())


def fields_to_plain(record: Any) -> dict[str, Any]:
    """The fields of a record by their names."""
    kind: Any = type(record)
    return {
        name: to_plain(getattr(record, name))
        for name, each in _fields(kind).items()
        if each.metadata != UNLESS_EMPTY or getattr(record, name)
    }


def from_plain(kind: type[Record], data: Any) -> Record:
    """The record of this kind that was given to `to_plain`.

    Raises:
        NotOfKind: naming the place where it is none.
        Exception: of any kind, where a record's own `from_dict` finds that it is none.
    """
    own = getattr(kind, "from_dict", None)
    return fields_from_plain(kind, data) if own is None else own(data)


def fields_from_plain(kind: type[Record], data: Any) -> Record:
    """The record with these fields; those that are missing have their defaults."""
    of_kind: Any = kind
    fields, readers = _fields(of_kind), _readers(of_kind)
    if isinstance(data, list):  # as earlier forms list them
        data = dict(zip(fields, data, strict=True))
    if not isinstance(data, Mapping):
        raise NotOfKind("give an object of names and values")
    found = {}
    for name, reader in readers.items():
        if name in data:
            try:
                found[name] = reader(data[name])
            except NotOfKind as error:
                raise error.below(name) from None
        elif fields[name].default is fields[name].default_factory is dataclasses.MISSING:
            raise NotOfKind("it is missing", name)
    return kind(**found)


@cache
def _fields(kind: Any) -> Mapping[str, dataclasses.Field[Any]]:
    return {each.name: each for each in dataclasses.fields(kind)}


@cache
def _readers(kind: Any) -> Mapping[str, Callable[[Any], Any]]:
    hints = get_type_hints(kind)
    return {name: _reader(hints[name]) for name in _fields(kind)}


@cache
def _reader(kind: Any) -> Callable[[Any], Any]:
    """Makes a value of a kind of plain data; NotOfKind where it is none."""
    origin, parts = get_origin(kind), get_args(kind)
    if origin in (UnionType, Union):
        return partial(_either, [_reader(part) for part in parts if part is not NoneType], NoneType in parts)
    if origin is np.ndarray:
        return partial(np.array, dtype=get_args(parts[1])[0])
    if origin in (tuple, frozenset):
        return partial(_entries, origin, _reader(parts[0]), parts[0] is float)
    if origin in (Mapping, dict):
        return partial(_named, _reader(parts[1]))
    if origin is Literal:
        return partial(_one_of, parts)
    if kind in (int, float, str, bool):
        return partial(_bare, kind)
    if isinstance(kind, type) and dataclasses.is_dataclass(kind):
        return partial(from_plain, kind)
    return lambda data: data


_WORDS = {int: "a whole number", float: "a finite number", str: "a text", bool: "true or false"}


def _shown(data: Any) -> str:
    return json.dumps(data, ensure_ascii=False, default=str)[:80]


def _bare(kind: type, data: Any) -> Any:
    if kind is float and type(data) is int:
        try:
            data = float(data)
        except OverflowError:
            data = math.inf
    if type(data) is not kind or (isinstance(data, float) and not math.isfinite(data)):
        raise NotOfKind(f"give {_WORDS[kind]}, not {_shown(data)}")
    return data


def _either(readers: list[Callable[[Any], Any]], none: bool, data: Any) -> Any:
    if none and data is None:
        return None
    for reader in readers[:-1]:
        try:
            return reader(data)
        except NotOfKind:
            continue
    return readers[-1](data)


def _entries(kind: Any, reader: Callable[[Any], Any], numbers: bool, data: Any) -> Any:
    if not isinstance(data, list | tuple):
        raise NotOfKind(f"give a list, not {_shown(data)}")
    if numbers and all(type(each) is float for each in data) and all(map(math.isfinite, data)):  # most, by far
        return kind(data)
    found = []
    for place, each in enumerate(data):
        try:
            found.append(reader(each))
        except NotOfKind as error:
            raise error.below(place) from None
    return kind(found)


def _named(reader: Callable[[Any], Any], data: Any) -> Any:
    if not isinstance(data, Mapping):
        raise NotOfKind("give an object of names and values")
    found = {}
    for name, each in data.items():
        try:
            found[name] = reader(each)
        except NotOfKind as error:
            raise error.below(name) from None
    return found


def _one_of(known: tuple[Any, ...], data: Any) -> Any:
    if data not in known:
        raise NotOfKind(f"give one of {', '.join(map(str, known))}, not {_shown(data)}")
    return data
