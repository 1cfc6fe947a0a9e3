"""The interface of a log."""

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
        """The name of the format."""

    @property
    def topics(self) -> tuple[Topic, ...]:
        """The topics by name."""

    @property
    def notes(self) -> tuple[str, ...]:
        """The notes on messages that could not be read, one sentence each; known after reading."""

    def read(self, names: Collection[str]) -> Mapping[str, Table]:
        """The messages of the topics named."""
