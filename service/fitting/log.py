"""Logs as people give them to a function: files, arrays, data frames, and what `read` returned."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from incsvr.errors import BadInput
from service.cli.extras import plots
from service.config.sources import read as read_config
from service.fitting.arrays import Arrays
from service.fitting.request import Request, Source, read_each
from service.fitting.results import frame
from service.inputs.units import si_unit
from service.recordings.recording import Recording


@dataclass(frozen=True, slots=True, repr=False)
class Log:
    """A log that was read.

    Attributes:
        source: the file, or the arrays.
        recording: what is in it.
        how: the keywords by which it was read.
    """

    source: Source
    recording: Recording
    how: Mapping[str, Any] = field(default_factory=dict)

    @staticmethod
    def read(request: Request, how: Mapping[str, Any]) -> Log:
        """The first log of a request."""
        source = request.recordings[0]
        reading = request.reading(read_config(request.config))
        return Log(source, read_each(reading, [source])[0], how)

    def __repr__(self) -> str:
        time, names = self.recording.time, [name for name in self.to_dict()["columns"] if name != "t"]
        return f"{self.recording.name}: {float(time[-1] - time[0]):.4g} s of {', '.join(names)}"

    def to_dict(self) -> dict[str, Any]:
        """The columns by name, `t` first, None where a channel was not sampled; and what is to be known of them."""
        recording = self.recording
        columns = {"t": recording.time, **recording.columns}
        return {
            "name": recording.name,
            "axis": recording.axis.name,
            "columns": {name: [None if v != v else v for v in values.tolist()] for name, values in columns.items()},
            "notes": list(recording.notes),
        }

    def plot(self) -> Any:
        """Velocity and torque over time, as a figure of matplotlib."""
        streams, axis = self.recording.own_streams, self.recording.axis
        drawn = {name: streams[name] for name in (axis.rate, axis.effort)}
        return plots().of_log(self.recording.name, drawn, {name: si_unit(name) for name in drawn})

    def to_frame(self) -> Any:
        """The columns as a DataFrame of pandas."""
        return frame(self.to_dict()["columns"])


def each_log(given: Any) -> list[Any]:
    """One log or several, as a list."""
    return list(given) if isinstance(given, list | tuple) else [given]


def source(name: str, given: Any) -> Source:
    """A log as it is read.

    Args:
        name: what refusals call arrays.

    Raises:
        BadInput: it is no log.
    """
    if isinstance(given, Log):
        return given.source
    if isinstance(given, str | os.PathLike):
        return Path(given)
    found = Arrays.of(name, given)
    if found is None:
        raise BadInput(
            f"a log is a file, arrays by the names of their columns, a DataFrame or what incsvr.read returned, not "
            f"{type(given).__name__}"
        )
    return found


def sources(name: str, given: Any) -> tuple[Source, ...]:
    """One log or several as they are read; arrays are called by the keyword they came by.

    Raises:
        BadInput: one is no log.
    """
    logs = each_log(given)
    return tuple(source(name if len(logs) == 1 else f"{name}[{k}]", each) for k, each in enumerate(logs))
