"""The topics of a log or a bus with their fields, and each topic's messages as a table of columns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from incsvr.numerics import Array

ROWS = "rows"
"""The name of the one topic of a log that is a table."""


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
    """

    arrival: Array | None
    columns: Mapping[str, Array]
    texts: Mapping[str, tuple[str, ...]]

    @property
    def count(self) -> int:
        """The number of messages."""
        if self.arrival is not None:
            return self.arrival.size
        sizes = [values.size for values in self.columns.values()] + [len(each) for each in self.texts.values()]
        return max(sizes, default=0)
