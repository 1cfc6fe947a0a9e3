"""Messages become tables: the numbers and texts of nested messages by their paths, in one column each."""

from __future__ import annotations

from array import array
from math import nan
from typing import Any

import numpy as np

from service.inputs.message_fields import leaves
from service.inputs.table import Table


class TableBuilder:
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
