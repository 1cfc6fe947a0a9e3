"""What a log is to everybody who reads one: topics with fields, and each topic's messages as a table of columns."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Protocol

from incsvr.numerics import Array


@dataclass(frozen=True, slots=True)
class Topic:
    """What a log or a bus carries under one name.

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


class Log(Protocol):
    """A log of any format.

    Raises:
        BadInput: on opening or reading, naming the file and the cure.
    """

    @property
    def format(self) -> str:
        """What people call the format."""

    @property
    def topics(self) -> tuple[Topic, ...]:
        """What is in it, by name."""

    @property
    def notes(self) -> tuple[str, ...]:
        """What of it could not be read, one sentence each; known once it was read."""

    def read(self, names: Collection[str]) -> Mapping[str, Table]:
        """The messages of the topics named."""
