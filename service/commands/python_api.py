"""`import incsvr` for people who write Python: the commands `fit` and `trace` by call, with results that can be drawn.

Keywords become the command's own flags and pass its own parser, so that both take the same and refuse the same.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn

from incsvr.errors import BadInput
from incsvr.free_run.fit_pictures import FitPictures
from incsvr.plant.axes import YAW, Axis
from incsvr.tracing.findings import Trace
from incsvr.vehicle import Identified
from service.cli.parser import Parser
from service.cli.progress import without_bars
from service.commands import fit as fit_command
from service.commands import identify as identify_command
from service.commands import trace as trace_command
from service.commands.identify_text import text as identify_text
from service.commands.trace_text import text as trace_text
from service.config.sources import read as read_config
from service.config.vehicle_file import write_vehicle
from service.recordings.manoeuvre import next_manoeuvre
from service.recordings.reading import Reading
from service.recordings.recording import Recording

PLOTS = "viewer.plots"
"""Draws; loaded when asked for, so that reading and learning need no drawing library."""
LOG_FLAGS = ("preset", "column", "system", "axis")
"""The flags that say what is in a log."""
SHELL_FLAGS = ("json", "report")
"""Flags whose work the result itself does."""


@dataclass(frozen=True, slots=True)
class Log:
    """A log that was read.

    Attributes:
        path: the file.
        recording: what is in it.
        flags: how it was read.
    """

    path: Path
    recording: Recording
    flags: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """The columns by name, `t` first, None where a channel was not sampled; and what is to be known of them."""
        recording = self.recording
        own = dict(zip((YAW.rate, YAW.effort), (recording.axis.rate, recording.axis.effort), strict=True))
        columns = {own.get(name, name): values for name, values in recording.columns.items()}
        columns = {"t": recording.time, **columns, **recording.displaced}
        return {
            "name": recording.name,
            "axis": recording.axis.name,
            "columns": {name: [None if v != v else v for v in values.tolist()] for name, values in columns.items()},
            "notes": list(recording.notes),
        }

    def plot(self) -> Any:
        """Velocity and torque over time, as a figure of matplotlib."""
        streams = self.recording.streams()
        return _plots().of_log(self.recording.name, streams[YAW.rate], streams[YAW.effort], self.recording.axis)


@dataclass(frozen=True, slots=True)
class CommandResult:
    """The result of a command; `str` is the printed text.

    Attributes:
        result: what it writes with `--json`.
        text: what it prints.
        axis: whose words both are in.
    """

    result: Mapping[str, Any] = field(repr=False)
    text: str = field(repr=False)
    axis: Axis

    def __str__(self) -> str:
        return self.text

    def to_dict(self) -> dict[str, Any]:
        """The JSON that the command writes with `--json`."""
        return dict(self.result)


@dataclass(frozen=True, slots=True)
class FitResult(CommandResult):
    """The result of `fit`."""

    pictures: FitPictures = field(repr=False)

    def plot(self) -> Any:
        """The damping curve beside its samples, as a figure of matplotlib."""
        return _plots().of_fit(self.pictures, self.axis)


@dataclass(frozen=True, slots=True)
class TraceResult(CommandResult):
    """The result of `trace`."""

    trace: Trace = field(repr=False)

    def plot(self) -> Any:
        """The damping, and a free run, before and after, as a figure of matplotlib."""
        return _plots().of_trace(self.trace, self.axis)


@dataclass(frozen=True, slots=True)
class IdentifyResult(CommandResult):
    """The model of a whole vehicle."""

    identified: Identified = field(repr=False)

    def plot(self) -> Any:
        """Prediction errors of every axis some seconds ahead, as a figure of matplotlib."""
        return _plots().of_vehicle(self.identified)


def read(log: Any, **how: Any) -> Log:
    """A log of any format as a recording; `how` are the flags `LOG_FLAGS`."""
    other = sorted(set(how) - set(LOG_FLAGS))
    if other:
        raise BadInput(f"read takes no {other[0]}; it takes {', '.join(LOG_FLAGS)}")
    path, flags = _path(log), _flags(how)
    args = _parsed("fit", fit_command, [str(path)], flags)
    with without_bars():
        recording = Reading.of(args, read_config(None)).of_one(path)
    return Log(path, recording, tuple(flags))


def fit(recordings: Any, validate: Any, flags: Mapping[str, Any]) -> FitResult:
    """`incsvr fit` by call."""
    args = _arguments("fit", fit_command, recordings, validate, flags)
    with without_bars():
        axis, learned, result, words = fit_command.answer(args)
    return FitResult(result, words, axis, learned.pictures)


def trace(recordings: Any, validate: Any, flags: Mapping[str, Any]) -> TraceResult:
    """`incsvr trace` by call."""
    args = _arguments("trace", trace_command, recordings, validate, flags)
    with without_bars():
        axis, found, result = trace_command.answer(args)
    words = trace_text(found)
    if args.manoeuvre is not None:
        words += f"\n  {next_manoeuvre(found.effects, args.manoeuvre)}"
    return TraceResult(result, words, axis, found)


def identify(recordings: Any, validate: Any, flags: Mapping[str, Any]) -> IdentifyResult:
    """`incsvr identify` by call."""
    args = _arguments("identify", identify_command, recordings, validate, flags)
    with without_bars():
        found, notes = identify_command.answer(args)
    if args.write is not None:
        write_vehicle(args.write, found.vehicle)
    return IdentifyResult({**found.to_dict(), "notes": list(notes)}, identify_text(found), YAW, found)


class _RaisingParser(Parser):
    """A command's parser whose refusals are raised: a call must not end the program."""

    def error(self, message: str) -> NoReturn:
        raise BadInput(self._sentence(message))


def _arguments(
    name: str, command: ModuleType, recordings: Any, validate: Any, flags: Mapping[str, Any]
) -> argparse.Namespace:
    """The command's arguments, as its own parser makes them of these."""
    for each in SHELL_FLAGS:
        if each in flags:
            raise BadInput(f"{name} takes no {each} in Python; the result has to_dict() and plot()")
    learned, unseen = _logs(recordings), _logs(validate)
    if not learned:
        raise BadInput(f"{name} needs a recording: a file, what read returned, or several")
    read_by = {each.flags for each in (*learned, *unseen) if isinstance(each, Log)}
    if len(read_by) > 1:
        raise BadInput("the logs were read with different flags; read all of them alike")
    words = [*_flags(flags), *(word for each in read_by for word in each)]
    paths = [[str(each.path if isinstance(each, Log) else _path(each)) for each in logs] for logs in (learned, unseen)]
    return _parsed(name, command, paths[0], words, paths[1])


def _parsed(
    name: str, command: ModuleType, paths: Iterable[str], words: Iterable[str], unseen: Iterable[str] = ()
) -> argparse.Namespace:
    parser = _RaisingParser(prog=f"incsvr {name}", add_help=False, allow_abbrev=False)
    command.add_arguments(parser)
    args: argparse.Namespace = parser.parse_args([*words, "--", *paths])
    args.validate = [Path(each) for each in unseen]
    args.command = name
    return args


def _flags(flags: Mapping[str, Any]) -> list[str]:
    """Keywords as the words of a command line; None and False leave a flag out."""
    words = []
    for name, value in flags.items():
        flag = f"--{name.replace('_', '-')}"
        if value is True:
            words.append(flag)
        elif value is not None and value is not False:
            several = value if isinstance(value, (list, tuple)) else [value]
            words += [f"{flag}={each}" for each in several]
    return words


def _logs(given: Any) -> list[Any]:
    """One log or several, as a list."""
    return list(given) if isinstance(given, (list, tuple)) else [given]


def _path(given: Any) -> Path:
    if not isinstance(given, (str, os.PathLike)):
        raise BadInput(f"a log is a file or what incsvr.read returned, not {type(given).__name__}")
    return Path(given)


def _plots() -> ModuleType:
    return import_module(PLOTS)
