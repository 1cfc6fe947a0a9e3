"""The one place that writes JSON: valid by RFC 8259, which has no NaN and no infinity; what is no number is null; and
the one that reads what others wrote, in which no name may stand twice: readers keep the first or the last of them.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np


class RepeatedName(ValueError):
    """A name stands twice in an object of JSON."""


def json_text(value: Any, *, indent: int | None = None, compact: bool = False) -> str:
    """A value as JSON, floats to the last bit; NumPy's arrays and numbers are written as lists and numbers.

    `compact` leaves out the spaces, as payloads of the bus do.
    """
    separators = (",", ":") if compact else None
    write = partial(json.dumps, indent=indent, separators=separators, allow_nan=False, ensure_ascii=False)
    try:
        return write(value, default=_plain)
    except ValueError:  # somewhere in it is what is no number
        return write(_finite(value))


def write_json(path: Path, value: Any, *, indent: int | None = None) -> None:
    """Writes a value as a file of JSON that ends its last line."""
    path.write_text(json_text(value, indent=indent) + "\n", encoding="utf-8")


def read_json(text: bytes | str) -> Any:
    """The value of a JSON text.

    Raises:
        ValueError: it is none, or gives a name twice.
    """
    try:
        return json.loads(text, object_pairs_hook=_each_once)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None


def _each_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise RepeatedName(f"{twice[:80]} is given twice; keep one of them")
    return found


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} has no place in JSON")


def _finite(value: Any) -> Any:
    """The value with None in the place of each number that is none."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {key: _finite(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(each) for each in value]
    return value
