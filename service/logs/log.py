"""The interface of a log, the tables that messages become, and the account of those that cannot be read.

Numbers and texts stand by their paths, in one column each. A broken message is left out, counted, and said; a log of
which most are broken is refused.
"""

from __future__ import annotations

from array import array
from collections import Counter
from collections.abc import Collection, Mapping
from math import nan
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from incsvr.errors import BadInput
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


MAX_BROKEN_PART = 0.5
"""Part of a topic's messages that may be broken: beyond, the log says something else than it means."""


def first_line(error: Exception) -> str:
    """The first line of an error of a package; its type if it has no text."""
    return str(error).splitlines()[0] if str(error) else type(error).__name__


class Damage:
    """The unreadable messages of a log, as far as it was read."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._broken, self._read = Counter[str](), Counter[str]()
        self._why: dict[str, str] = {}
        self._ended: str | None = None
        self._skipped = 0

    def add_read(self, topic: str) -> None:
        """A message of the topic was read."""
        self._read[topic] += 1

    def add_broken(self, topic: str, error: Exception) -> None:
        """A message of the topic could not be read."""
        self._broken[topic] += 1
        self._why[topic] = first_line(error)

    def add_end(self, name: str, after: float, error: Exception) -> None:
        """The file ends, or is damaged, so many seconds after its first message."""
        self._ended = (
            f"{name} ends early, {after:.3g} s after its first message ({first_line(error)}): nothing beyond it is read"
        )

    def add_skipped(self, count: int) -> None:
        """Counts bytes that belong to no message."""
        self._skipped += count

    def begin(self, topics: set[str]) -> None:
        """Starts the counts of these topics from zero, because they are read again."""
        for topic in topics:
            self._broken.pop(topic, None)
            self._read.pop(topic, None)

    @property
    def notes(self) -> tuple[str, ...]:
        """A sentence for each topic with broken messages, and one for a file that ends early."""
        found = []
        for topic, count in sorted(self._broken.items()):
            whole = count + self._read[topic]
            found.append(f"{count} of {whole} messages of {topic} cannot be read and are left out ({self._why[topic]})")
        if self._skipped:
            found.append(f"{self._skipped} bytes of the file belong to no whole message and are left out")
        return (*found, *([self._ended] if self._ended else []))

    def refuse(self) -> None:
        """Raises BadInput where most messages of a topic cannot be read."""
        for topic, count in sorted(self._broken.items()):
            whole = count + self._read[topic]
            if count > MAX_BROKEN_PART * whole:
                raise BadInput(
                    f"{self._path}: {count} of {whole} messages of {topic} cannot be read ({self._why[topic]}): record "
                    "again with the definition of the message that the driver sends, or mend the file"
                )
