"""A key of the bus that was heard: how its messages are read, and those that wait to be mapped."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from math import nan
from typing import Any

import numpy as np

from service.inputs.forms import as_float, number
from service.inputs.table import MESSAGE, Table
from service.inputs.vehicles import VehicleEvidence


@dataclass(slots=True)
class SourceBinding:
    """A key that was heard.

    Attributes:
        form: of its messages.
        decode: what reads them; None where nothing does.
        fields: paths of what stands in them, as the first one showed.
        message: the newest.
        count: of messages; the first and the last of them came at these times [s].
        evidence: what they show of the vehicle that they are of.
        numbers: the paths of the numbers that are taken from them.
        stamps: the paths of their stamps.
        moved: whether the yaw rate that they may hold has ever changed.
    """

    form: str
    decode: Callable[[bytes], Any] | None
    fields: tuple[str, ...] = ()
    message: Any = None
    count: int = 0
    first: float = 0.0
    last: float = 0.0
    evidence: VehicleEvidence | None = None
    numbers: tuple[str, ...] = ()
    stamps: tuple[str, ...] = ()
    moved: bool = False
    _rate: float | None = None
    _arrival: array[float] = field(default_factory=lambda: array("d"))
    _columns: dict[str, array[float]] = field(default_factory=dict)

    @property
    def type(self) -> str:
        """The type of its messages: that of CDR, or the form that says what stands in them; empty for plain JSON."""
        return "" if self.form == "json" else self.form.removeprefix("cdr:")

    def look_at_rate(self, path: str) -> None:
        """Compares the yaw rate of the newest message with the one before."""
        rate = number(self.message, path)
        self.moved |= self._rate is not None and rate is not None and rate != self._rate
        self._rate = rate

    def rows(self) -> tuple[dict[str, list[float]], list[str]]:
        """The numbers of the newest message by their paths, as many of each, and why some are left out."""
        read = {path: numbers(self.message, path) for path in dict.fromkeys((*self.numbers, *self.stamps))}
        count = max((len(each) for each in read.values() if each is not None), default=0)
        found = {path: each for path, each in read.items() if each is not None and len(each) == count}
        if count > 1 and not found.keys() & set(self.stamps):
            return {}, ["unequal_length"]
        reasons = ["no_field" for path in self.numbers if read[path] is None][:1]
        return found, [*reasons, *("unequal_length" for each in read.values() if each and len(each) != count)]

    def fits(self, rows: Iterable[str]) -> bool:
        """Whether rows with these paths continue those that wait."""
        return not self._arrival or self._columns.keys() == {MESSAGE, *rows}

    def wait(self, rows: dict[str, list[float]], arrival: float, message: int) -> None:
        """Adds rows of one message, which has this running number, to those that wait."""
        count = max(map(len, rows.values()), default=0)
        self._arrival.extend([arrival] * count)
        for path, values in {**rows, MESSAGE: [float(message)] * count}.items():
            self._columns.setdefault(path, array("d")).extend(values)

    def table(self) -> Table | None:
        """The rows that wait, which then no longer do; None without any."""
        arrival, columns = self._arrival, self._columns
        self._arrival, self._columns = array("d"), {}
        return (
            Table(np.array(arrival), {path: np.array(each) for path, each in columns.items()}, {}) if arrival else None
        )


def numbers(message: Any, path: str) -> list[float] | None:
    """The number at a path of a message, or all of a list that stands there; None without any."""
    if type(message) is dict and type(message.get(path)) is list:
        return [nan if (value := as_float(each)) is None else value for each in message[path]]
    found = number(message, path)
    return None if found is None else [found]
