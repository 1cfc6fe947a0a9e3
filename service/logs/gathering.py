"""Messages become tables: the numbers and texts of nested messages by their paths, in one column each."""

from __future__ import annotations

from array import array
from collections.abc import Iterator, Mapping, Sequence
from math import nan
from typing import Any

import numpy as np

from service.logs.table import Table

LONGEST = 64
"""A list with more items is a picture or a point cloud, of which nothing is learned."""
DEEPEST = 8
"""Messages are nested less deeply than this."""


def leaves(message: Any, path: str = "", depth: int = 0) -> Iterator[tuple[str, float | str]]:
    """Numbers and texts of a message with their paths: `angular_velocity.z`, `data[3]`, `message.param_id`.

    A list of single characters is a text: so MAVLink's JSON writes names.
    """
    if isinstance(message, bool | int | float | np.number | np.bool_):
        yield path, float(message)
    elif isinstance(message, str):
        yield path, message
    elif isinstance(message, Mapping):
        if depth < DEEPEST:
            for name, value in message.items():
                yield from leaves(value, f"{path}.{name}" if path else str(name), depth + 1)
    elif isinstance(message, Sequence | np.ndarray) and 0 < len(message) <= LONGEST:
        if all(isinstance(item, str) and len(item) <= 1 for item in message):
            yield path, "".join(message).rstrip("\0")
        elif not isinstance(message, bytes | bytearray):
            for index, item in enumerate(message):
                yield from leaves(item, f"{path}[{index}]", depth + 1)


class Gathering:
    """The messages of one topic on their way into a table."""

    def __init__(self) -> None:
        self._arrival = array("d")
        self._columns: dict[str, array[float]] = {}
        self._texts: dict[str, list[str]] = {}

    def __len__(self) -> int:
        return len(self._arrival)

    @property
    def fields(self) -> tuple[str, ...]:
        """The paths of the numbers."""
        return tuple(self._columns)

    def add(self, arrival: float, message: Any) -> None:
        """One message more, which was written down at `arrival` [s]."""
        count = len(self._arrival)
        self._arrival.append(arrival)
        for path, value in leaves(message):
            if isinstance(value, str):
                texts = self._texts.setdefault(path, [])
                texts.extend("" for _ in range(count - len(texts)))
                texts.append(value)
            else:
                column = self._columns.setdefault(path, array("d"))
                column.extend(nan for _ in range(count - len(column)))
                column.append(value)

    def table(self) -> Table:
        count = len(self._arrival)
        for column in self._columns.values():
            column.extend(nan for _ in range(count - len(column)))
        for texts in self._texts.values():
            texts.extend("" for _ in range(count - len(texts)))
        return Table(
            np.array(self._arrival),
            {path: np.array(column) for path, column in self._columns.items()},
            {path: tuple(texts) for path, texts in self._texts.items()},
        )
