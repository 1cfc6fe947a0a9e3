"""`import incsvr` for people who write Python: the commands `fit` and `trace` by call, with results that can be drawn.

Keywords become the command's own flags and pass its own parser, so that both take the same and refuse the same.
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn

import numpy as np

from incsvr.errors import BadInput
from incsvr.plant.axes import YAW
from service.cli.parser import Parser
from service.cli.progress import without_bars
from service.commands import compare as compare_command
from service.commands import fit as fit_command
from service.commands import identify as identify_command
from service.commands import trace as trace_command
from service.commands.identify_text import text as identify_text
from service.commands.python_results import CompareResult, FitResult, IdentifyResult, Log, TraceResult
from service.commands.trace_text import text as trace_text
from service.config.sources import read as read_config
from service.recordings.reading import Reading

LOG_FLAGS = ("preset", "column", "system", "axis")
"""The flags that say what is in a log."""
SHELL_FLAGS = ("json", "report")
"""Flags whose work the result itself does."""


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
    return TraceResult(result, trace_text(found), axis, found)


def identify(recordings: Any, validate: Any, flags: Mapping[str, Any]) -> IdentifyResult:
    """`incsvr identify` by call."""
    args = _arguments("identify", identify_command, recordings, validate, flags)
    with without_bars():
        found, notes = identify_command.answer(args)
    return IdentifyResult({**found.to_dict(), "notes": list(notes)}, identify_text(found), YAW, found)


def compare(dives: Any, flags: Mapping[str, Any]) -> CompareResult:
    """`incsvr compare` by call."""
    args = _arguments("compare", compare_command, dives, (), flags)
    with without_bars():
        compared = compare_command.answer(args)
    return CompareResult(compare_command.to_dict(compared), compare_command.text(compared), YAW, compared)


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
    words = dict.fromkeys((*_flags(flags), *(word for each in read_by for word in each)))
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
            if name == "set" and isinstance(value, Mapping):
                value = [f"{key}={_written(key, each)}" for key, each in value.items()]
            several = value if isinstance(value, (list, tuple)) else [value]
            words += [f"{flag}={each}" for each in several]
    return words


def _written(key: str, value: Any) -> str:
    """A value of the configuration as the command line takes it: a text as it is, all else as JSON."""
    if isinstance(value, str):
        return value
    try:
        return json.dumps(np.asarray(value).tolist())
    except (TypeError, ValueError):
        raise BadInput(f"{key}: give a text, a number, or a list or an array of them") from None


def _logs(given: Any) -> list[Any]:
    """One log or several, as a list."""
    return list(given) if isinstance(given, (list, tuple)) else [given]


def _path(given: Any) -> Path:
    if not isinstance(given, (str, os.PathLike)):
        raise BadInput(f"a log is a file or what incsvr.read returned, not {type(given).__name__}")
    return Path(given)
