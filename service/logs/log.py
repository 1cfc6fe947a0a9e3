"""The interface of a log, and the tables that messages become: numbers and texts by their paths, in one column each."""

from __future__ import annotations

from array import array
from collections.abc import Collection, Mapping
from math import nan
from typing import Any, Protocol

import numpy as np

from service.inputs.table import Table, Topic, leaves


class Log(Protocol):
    """A log of any format.

    Raises:
        BadInput: on opening or reading, naming the file and the cure.
    """

    @property
    def format(self) -> str:
        """The name of the format."""

    @property
    def topics(self) -> tuple[Topic, ...]:
        """The topics by name."""

    @property
    def notes(self) -> tuple[str, ...]:
        """The notes on messages that could not be read, one sentence each; known after reading."""

    def read(self, names: Collection[str]) -> Mapping[str, Table]:
        """The messages of the topics named."""


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
