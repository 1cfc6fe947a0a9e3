"""A log as a value: the tables that its messages become, and the account of those that cannot be read.

Numbers and texts stand by their paths, in one column each. A broken message is left out, counted, and said; a topic of
which most are broken is refused where it is needed.
"""

from __future__ import annotations

from array import array
from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from math import nan
from pathlib import Path
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array
from service.inputs.owners import base
from service.inputs.table import ROWS, Table, Topic, leaves

MAX_BROKEN_PART = 0.5
"""Part of a topic's messages that may be broken: beyond, the log says something else than it means."""


@dataclass(frozen=True, slots=True)
class Broken:
    """The messages of a topic that cannot be read.

    Attributes:
        path: of the file.
        topic: without the instance of its messages.
        count: of them.
        whole: of all messages of the topic.
        why: what the last of them was refused with.
    """

    path: Path
    topic: str
    count: int
    whole: int
    why: str

    @property
    def note(self) -> str:
        """The sentence on messages that are few."""
        return f"{self._counts} and are left out ({self.why})"

    @property
    def _counts(self) -> str:
        return f"{self.count} of {self.whole} messages of {self.topic} cannot be read"

    def refuse(self) -> None:
        """Raises BadInput where these are most of its messages."""
        if self.count > MAX_BROKEN_PART * self.whole:
            raise BadInput(
                f"{self.path}: {self._counts} ({self.why}): record again with the definition of the message that the "
                "driver sends, or mend the file"
            )


@dataclass(frozen=True, slots=True)
class Log:
    """A log of any format, as it was read.

    Attributes:
        format: the name of the format.
        topics: by name.
        tables: the messages by topic, of all forms that are read here.
        notes: sentences on the file as a whole.
        broken: the messages that cannot be read.
    """

    format: str
    topics: tuple[Topic, ...]
    tables: Mapping[str, Table]
    notes: tuple[str, ...] = ()
    broken: tuple[Broken, ...] = ()

    def read(self, names: Collection[str]) -> dict[str, Table]:
        """The messages of the topics named.

        Raises:
            BadInput: most messages of one cannot be read.
        """
        for each in self._broken(names):
            each.refuse()
        return {name: table for name, table in self.tables.items() if name in names}

    def notes_on(self, names: Collection[str]) -> tuple[str, ...]:
        """A sentence for each of these topics with broken messages, and those on the file as a whole."""
        return (*(each.note for each in self._broken(names)), *self.notes)

    def _broken(self, names: Collection[str]) -> list[Broken]:
        plain = {base(name) for name in names}
        return [each for each in self.broken if each.topic in plain]


def table_log(form: str, table: Table, notes: tuple[str, ...] = ()) -> Log:
    """A log that is one table: a topic whose fields are its columns.

    Nothing says when its rows were written down, but a column that is the time.
    """
    table = replace(table, columns={**table.columns, **_joined_stamps(table.columns)})
    return Log(form, (Topic(ROWS, "", tuple(table.columns), table.count),), {ROWS: table}, notes)


_STAMP_PARTS = (("secs", "nsecs"), ("sec", "nanosec"), ("sec", "nsec"))


def _joined_stamps(columns: Mapping[str, Array]) -> dict[str, Array]:
    """Stamps [s] of columns that hold their seconds and nanoseconds, as exports of ROS have them."""
    found = {}
    for name, seconds in columns.items():
        for whole, part in _STAMP_PARTS:
            begin = name.removesuffix(whole)
            if name.endswith(whole) and f"{begin}{part}" in columns:
                found[begin.rstrip("._/") or "stamp"] = seconds + 1e-9 * columns[f"{begin}{part}"]
    return {name: stamps for name, stamps in found.items() if name not in columns}


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
            np.frombuffer(self._arrival),
            {path: np.frombuffer(column) for path, column in self._columns.items()},
            {path: tuple(texts) for path, texts in self._texts.items()},
        )


def first_line(error: Exception) -> str:
    """The first line of an error of a package; its type if it has no text."""
    return str(error).splitlines()[0] if str(error) else type(error).__name__


class Damage:
    """The account of what cannot be read in a file, while it is read."""

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

    @property
    def broken(self) -> tuple[Broken, ...]:
        """The broken messages by topic."""
        counts = sorted(self._broken.items())
        return tuple(
            Broken(self._path, topic, count, count + self._read[topic], self._why[topic]) for topic, count in counts
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """The sentences on bytes that were skipped, and on a file that ends early."""
        skipped = f"{self._skipped} bytes of the file belong to no whole message and are left out"
        return (*([skipped] if self._skipped else []), *([self._ended] if self._ended else []))
