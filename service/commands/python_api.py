"""`import incsvr` for people who write Python: the commands `fit` and `trace` by call, with results that can be drawn.

Keywords become the command's own flags and pass its own parser, so that both take the same and refuse the same.
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from incsvr.errors import BadInput
from incsvr.learning.fit_pictures import FitPictures
from incsvr.learning.prediction import Prediction
from incsvr.plant.axes import YAW, Axis
from incsvr.plant.terms import mass_unit, stage_unit, thrust_name
from incsvr.tracing.findings import Trace
from incsvr.vehicle import Comparison, Identified
from service.cli.extras import how_to_install
from service.cli.parser import Parser
from service.cli.progress import without_bars
from service.commands import compare as compare_command
from service.commands import fit as fit_command
from service.commands import identify as identify_command
from service.commands import trace as trace_command
from service.commands.arguments import PLOTS
from service.commands.identify import text as identify_text
from service.commands.trace import text as trace_text
from service.config.sources import read as read_config
from service.inputs.units import si_unit
from service.recordings.reading import Reading
from service.recordings.recording import Recording


@dataclass(frozen=True, slots=True, repr=False)
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
        streams, axis = self.recording.body_streams(), self.recording.axis
        drawn = {name: streams[name] for name in (axis.rate, axis.effort)}
        return _plots().of_log(self.recording.name, drawn, {name: si_unit(name) for name in drawn})

    def to_frame(self) -> Any:
        """The columns as a DataFrame of pandas."""
        return _frame(self.to_dict()["columns"])


@dataclass(frozen=True, slots=True, repr=False)
class CommandResult:
    """The result of a command; `str` and `repr` are the printed text.

    Attributes:
        result: what it writes with `--json`.
        text: what it prints.
        axis: whose words both are in.
    """

    result: Mapping[str, Any]
    text: str
    axis: Axis

    def __repr__(self) -> str:
        return self.text

    def to_dict(self) -> dict[str, Any]:
        """The JSON that the command writes with `--json`."""
        return dict(self.result)


@dataclass(frozen=True, slots=True, repr=False)
class FitResult(CommandResult):
    """The result of `fit`."""

    pictures: FitPictures

    def plot(self) -> Any:
        """The damping curve beside its samples, as a figure of matplotlib."""
        return _plots().of_fit(self.pictures, self.axis)

    def to_frame(self) -> Any:
        """The damping curve as a DataFrame of pandas: rate, damping, sigma of a sample about it and its own doubt."""
        return _frame(self.result["curve"])

    def predict(self, rate: ArrayLike) -> Prediction:
        """Damping, sigma, doubt and whether it is extrapolated at (n,) rates, or one."""
        return self.pictures.model.predict(rate)


@dataclass(frozen=True, slots=True, repr=False)
class TraceResult(CommandResult):
    """The result of `trace`."""

    trace: Trace

    def plot(self) -> Any:
        """The damping, and a free run, before and after, as a figure of matplotlib."""
        return _plots().of_trace(self.trace, self.axis)

    def to_frame(self) -> Any:
        """One row for each parameter of each effect, as a DataFrame of pandas."""
        return _frame(
            [
                {
                    "effect": each["effect"], "parameter": name, "estimate": value,
                    **dict(zip(("low", "high"), each["interval"].get(name, (None, None)), strict=True)),
                    "p_value": each["p_value"], "share": each["share"],
                }
                for each in self.result["effects"]
                for name, value in each["parameters"].items()
            ],
            ("effect", "parameter", "estimate", "low", "high", "p_value", "share"),
        )  # fmt: skip


@dataclass(frozen=True, slots=True, repr=False)
class IdentifyResult(CommandResult):
    """The result of `identify`: the model of a whole vehicle."""

    identified: Identified

    def plot(self) -> Any:
        """Prediction errors of every axis some seconds ahead, as a figure of matplotlib."""
        return _plots().of_vehicle(self.identified)

    def to_frame(self) -> Any:
        """One row for each parameter of each axis, with its interval, as a DataFrame of pandas."""
        vehicle = self.identified.vehicle
        named = [
            (one, "inertia" if one == other else f"inertia with {other}", mass_unit(one, other), parameter)
            for (one, other), parameter in vehicle.mass.items()
        ]
        named += [(term.axis, term.name, term.unit, parameter) for term, parameter in vehicle.terms.items()]
        named += [(axis, "thrust lag", "s", parameter) for axis, parameter in vehicle.lags.items()]
        named += [
            (axis, thrust_name(name), stage_unit(axis, name), p)
            for axis, of in vehicle.thrust.items() for name, p in of.items()
        ]  # fmt: skip
        rows = [{"axis": axis, "parameter": name, "unit": unit, **p.to_dict()} for axis, name, unit, p in named]
        return _frame(rows)


@dataclass(frozen=True, slots=True, repr=False)
class CompareResult(CommandResult):
    """The result of `compare`: the dives of one vehicle."""

    compared: Comparison

    def plot(self) -> Any:
        """Inertia and drag of every axis over the dives, with intervals, as a figure of matplotlib."""
        return _plots().of_comparison(self.compared)

    def to_frame(self) -> Any:
        """One row for each dive and quantity, as a DataFrame of pandas."""
        return _frame(self.compared.rows())


def _frame(data: Mapping[str, Any] | Sequence[Mapping[str, Any]], columns: Sequence[str] | None = None) -> Any:
    """A DataFrame of columns by name, or of rows; `columns` names them where there may be no row."""
    try:
        pandas = import_module("pandas")
    except ModuleNotFoundError:
        raise BadInput(f"to_frame() needs pandas, which is not installed: {how_to_install('pandas')}") from None
    return pandas.DataFrame(data, columns=columns)


def _plots() -> ModuleType:
    return import_module(PLOTS)


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
    return TraceResult(result, trace_text(found, result["next"]), axis, found)


def identify(recordings: Any, validate: Any, flags: Mapping[str, Any]) -> IdentifyResult:
    """`incsvr identify` by call."""
    args = _arguments("identify", identify_command, recordings, validate, flags)
    with without_bars():
        found, notes = identify_command.answer(args)
    return IdentifyResult(identify_command.to_dict(args, found, notes), identify_text(args, found), YAW, found)


def compare(dives: Any, flags: Mapping[str, Any]) -> CompareResult:
    """`incsvr compare` by call."""
    args = _arguments("compare", compare_command, dives, (), flags)
    with without_bars():
        compared = compare_command.answer(args)
    return CompareResult(compare_command.to_dict(args, compared), compare_command.text(args, compared), YAW, compared)


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
