"""What a log is to everybody who reads one."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Protocol

from service.inputs.table import Table, Topic


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
