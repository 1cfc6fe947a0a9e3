"""The topics of a log or a bus, each topic's messages as a table of columns, and the paths in a message."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from incsvr.numerics import Array

StampUnit = Literal["s", "ms", "us", "ns", "min", "h", "d"]
ROWS = "rows"
"""The name of the one topic of a log that is a table."""
MESSAGE = "(message)"
"""The column with the running number of a row's message, on a bus: no field has a bracket."""


class Assumption(str):
    """A note on what was assumed, with the key that says it: a refusal begins with it."""


@dataclass(frozen=True, slots=True)
class Topic:
    """The fields and the count of messages under one name.

    Attributes:
        name: as the log or the bus calls it.
        type: of its messages, such as `sensor_msgs/msg/Imu`; empty where they have none.
        fields: paths of the numbers in a message, such as `angular_velocity.z` or `xyz[2]`, as one message shows them.
        count: messages.
        system: the vehicle whose it is, where the name does not say so.
    """

    name: str
    type: str
    fields: tuple[str, ...]
    count: int
    system: str = ""


@dataclass(frozen=True, slots=True)
class Table:
    """The messages of a topic.

    Attributes:
        arrival: (n,) when each was written down, by the clock of the log [s]; None where nothing says when.
        columns: (n,) numbers by field, NaN where a message has none.
        texts: n texts by field, empty where a message has none.
        instants: the fields that were dates or times of day.
        in_si: the fields whose unit stood among their cells, and is used already.
    """

    arrival: Array | None
    columns: Mapping[str, Array]
    texts: Mapping[str, tuple[str, ...]]
    instants: tuple[str, ...] = ()
    in_si: tuple[str, ...] = ()

    @property
    def count(self) -> int:
        """The number of messages."""
        if self.arrival is not None:
            return self.arrival.size
        sizes = [values.size for values in self.columns.values()] + [len(each) for each in self.texts.values()]
        return max(sizes, default=0)


HEADER_STAMP = "header.stamp"
"""The path at which the stamp of a message of ROS with a header is found [s]."""
_USUAL: tuple[tuple[str, StampUnit], ...] = (
    ("time_boot_ms", "ms"),
    ("message.time_boot_ms", "ms"),
    ("time_usec", "us"),
    ("message.time_usec", "us"),
    (HEADER_STAMP, "s"),
)
"""Path and unit of the stamps of MAVLink, in a telemetry log and in JSON, and of ROS."""


def usual_stamp(fields: Collection[str]) -> tuple[str, StampUnit]:
    """Path and unit of the stamp in messages with these fields; an empty path where the time of arrival counts."""
    return next((found for found in _USUAL if found[0] in fields), ("", "s"))


MAX_LIST_ITEMS = 64
"""Items of a list that are looked at: one with more is a picture or a point cloud, of which nothing is learned."""
MAX_DEPTH = 8
"""The depth to which nested messages are looked into."""


def leaves(message: Any, path: str = "", depth: int = 0) -> Iterator[tuple[str, float | str]]:
    """Numbers and texts of a message with their paths: `angular_velocity.z`, `data[3]`, `message.param_id`.

    A list of single characters is a text: so MAVLink's JSON writes names. A number beyond all floats is none.
    """
    if isinstance(message, bool | int | float | np.number | np.bool_):
        with suppress(OverflowError):
            yield path, float(message)
    elif isinstance(message, str):
        yield path, message
    elif isinstance(message, Mapping):
        if depth < MAX_DEPTH:
            for name, value in message.items():
                yield from leaves(value, f"{path}.{name}" if path else str(name), depth + 1)
    elif isinstance(message, Sequence | np.ndarray) and 0 < len(message) <= MAX_LIST_ITEMS:
        if all(isinstance(item, str) and len(item) <= 1 for item in message):
            yield path, "".join(message).rstrip("\0")
        elif not isinstance(message, bytes | bytearray):
            for index, item in enumerate(message):
                yield from leaves(item, f"{path}[{index}]", depth + 1)


def table_of(message: Any) -> Table:
    """One message as a table."""
    found = dict(leaves(message))
    numbers = {path: np.array([value]) for path, value in found.items() if not isinstance(value, str)}
    return Table(None, numbers, {path: (value,) for path, value in found.items() if isinstance(value, str)})
