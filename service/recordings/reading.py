"""Logs of any format as recordings: the one way by which `fit`, `trace`, `tune`, `replay` and `convert` read files."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from incsvr.errors import BadInput
from incsvr.plant.axes import AXES, YAW, Axis
from service.cli.progress import progress
from service.config.configuration import Config
from service.inputs.column_spec import of_this_log, split_file, typed_source_with_unit
from service.inputs.presets import NAMES
from service.inputs.table import ROWS
from service.logs import Log, open_any
from service.logs import reading as logs
from service.logs.candidates import refuse_without_numbers
from service.logs.csv_log import open_log as open_csv
from service.logs.cutting import WHOLE_LOG, Cut, EmptyCut, add_cut_arguments
from service.logs.dives import Dive, dives
from service.logs.own_table import is_ours
from service.logs.reading import NO_DESCRIPTION, LogDescription
from service.recordings.log_recording import recording_of
from service.recordings.log_refusals import beside_assumptions
from service.recordings.recording import Recording

RATE_LIMIT = YAW.fastest
"""Largest plausible yaw rate [rad/s], about one turn a second: beyond, the column is probably in degrees per second."""


@dataclass(frozen=True, slots=True)
class Reading:
    """The settings by which files are read.

    Attributes:
        description: what a person says of them.
        rate_limit: largest plausible magnitude of the yaw rate [rad/s].
        limit_is: what the user may raise it by, if there is such a thing.
        learns: whether it is read to be learned from: then only what was measured while the vehicle was armed is taken,
            and a log in which it never turned is refused; else `armed` is a channel.
        ours_whole: whether our own recordings keep the time when the vehicle was not armed: `armed` is then a channel
            that effects are looked for in.
        axis: which is meant.
        cut: the part of each recording that is taken.
        several: whether a command reads several logs, of which one may need flags of its own.
    """

    description: LogDescription = NO_DESCRIPTION
    rate_limit: float = RATE_LIMIT
    limit_is: str = ""
    learns: bool = True
    ours_whole: bool = False
    axis: Axis = YAW
    cut: Cut = WHOLE_LOG
    several: bool = False

    @staticmethod
    def of(args: Any, config: Config) -> Reading:
        """The settings by the flags of `add_log_arguments`, as attributes, and by the given configuration."""
        said = {"preset": args.preset, "system": args.system}
        inputs = config.inputs.model_copy(update={name: value for name, value in said.items() if value is not None})
        axis = AXES[getattr(args, "axis", YAW.name) or config.vehicle.axis]
        _refuse_other_files(args)
        return replace(
            Reading.configured(config, axis),
            description=LogDescription(tuple(args.column), inputs),
            cut=Cut.of(args),
            several=len(_files(args)) > 1,
        )

    @staticmethod
    def configured(config: Config, axis: Axis | None = None) -> Reading:
        """The settings by a configuration alone, of its axis or another one."""
        axis = AXES[config.vehicle.axis] if axis is None else axis
        limited = "rate_limit" in config.vehicle.model_fields_set
        return Reading(
            LogDescription((), config.inputs),
            config.vehicle.rate_limit if limited else axis.fastest,
            "vehicle.rate_limit in the configuration" if limited else "vehicle.rate_limit in a --config FILE",
            axis=axis,
        )

    @property
    def undescribed(self) -> Reading:
        """The reading without a description, for recordings of our own."""
        return replace(self, description=NO_DESCRIPTION)

    @property
    def whole(self) -> Reading:
        """The reading without a cut, for recordings that are validated on."""
        return replace(self, cut=WHOLE_LOG)

    def of_all(self, paths: Sequence[Path]) -> list[Recording]:
        """Each dive as a recording: a file, or several that are parts of one; those that a cut leaves out are said.

        Raises:
            EmptyCut: the cut holds nothing of any of them.
        """
        found, left_out = list[Recording](), list[EmptyCut]()
        several = len(paths) > 1  # one alone is no step
        with progress("reading" if several else f"reading {paths[0].name}", len(paths) if several else None) as advance:
            for dive in dives(paths, self.description, self._opened):
                try:
                    found.append(self._of_dive(dive))
                except EmptyCut as error:
                    left_out.append(error)
                except BadInput as error:
                    raise self._named(error, dive.path.name) from None
                advance()
        if left_out and not found:
            raise left_out[0]
        if left_out:
            notes = (f"{error}; it is left out" for error in left_out)
            found[0] = replace(found[0], notes=(*found[0].notes, *notes))
        return found

    def _of_dive(self, dive: Dive) -> Recording:
        mine = self.description.of(dive.path.name)
        if mine != self.description:
            return replace(self, description=mine)._of_dive(dive)
        if len(dive.parts) == 1:
            return self.of_one(dive.parts[0].path, dive.parts[0].log)
        recording = self.of_one(dive.path, dive.opened(self.description))
        return replace(recording, name=dive.name, notes=(*dive.notes, *recording.notes))

    def _named(self, error: BadInput, name: str) -> BadInput:
        """A refusal of one log of several, whose flags are for that one alone."""
        return type(error)(of_this_log(str(error), name)) if self.several else error

    def of_one(self, path: Path, log: Log | None = None) -> Recording:
        """A file as a recording.

        Args:
            log: what is in it, where it was opened before.

        Raises:
            BadInput: naming the file, what is wrong or missing, and the cure.
        """
        log = self._opened(path) if log is None else log
        refuse_without_numbers(path, log)
        description = self.description
        if self.axis != YAW:
            description = replace(description, columns=_with_own_columns(path, log, description, self.axis))
        proposal = logs.describe(log, description, self.axis)
        measured = logs.read(path, log, proposal, self.axis)
        with beside_assumptions((*proposal.sentences, *measured.notes)):
            return recording_of(self, path, log, proposal, measured)

    def _opened(self, path: Path) -> Log:
        """The log in a file; one of our own, which nobody describes, with every fault of a row named."""
        if self.description.of(path.name) != NO_DESCRIPTION or not is_ours(path, self.axis):
            return open_any(path)
        return open_csv(path, ours=True)


def read(path: Path, axis: Axis = YAW) -> Recording:
    """A recording of our own, with the time when the vehicle was not armed.

    Raises:
        BadInput: as of `Reading.of_one`.
    """
    return Reading(rate_limit=axis.fastest, learns=False, axis=axis).of_one(path)


def _with_own_columns(path: Path, log: Log, description: LogDescription, axis: Axis) -> tuple[str, ...]:
    """The declared columns, and those of a table that have the axis's own names, or that a preset finds.

    Raises:
        BadInput: the velocity or the effort of the axis is neither said nor there, and how to say it.
    """
    columns = description.columns
    said = {split_file(text)[1].partition("=")[0] for text in columns}
    there = {field for topic in log.topics if topic.name == ROWS for field in topic.fields}
    found = {own: own for own in (axis.rate, axis.effort) if own in there}
    if not found.keys() | said >= {axis.rate, axis.effort}:
        proposed = logs.describe(log, description).inputs.channels
        found |= {name: typed_source_with_unit(proposed[name]) for name in (axis.rate, axis.effort) if name in proposed}
    absent = [own for own in (axis.rate, axis.effort) if own not in said | found.keys()]
    if absent:
        flags = " ".join(f"--column {own}=NAME" for own in absent)
        names = {axis.rate: f"{axis.name} {'velocity' if axis.along else 'rate'}", axis.effort: axis.effort}
        called = " and no ".join(names[own].replace("_", " ") for own in absent)
        raise BadInput(f"{path}: no {called} found; add {flags} (`incsvr inspect {path}` lists the names)")
    return (*columns, *(f"{own}={place}" for own, place in found.items() if own not in said))


def _files(args: Any) -> list[Path]:
    """The logs that a command reads."""
    return [path for name in ("recordings", "dives", "validate") for path in getattr(args, name, ())]


def _refuse_other_files(args: Any) -> None:
    """Raises BadInput where `--column FILE:NAME=FIELD` names a log that is not read."""
    names = [path.name for path in _files(args)]
    for text in args.column:
        file, _ = split_file(text)
        if file and file not in names:
            raise BadInput(f"--column {text}: there is no log {file} among {', '.join(names[:6])}")


def add_log_arguments(parser: argparse.ArgumentParser, config: bool = False, axis: bool = True) -> None:
    """The flags by which a person says what is in a log; of a configuration, and of an axis."""
    parser.add_argument("--preset", choices=NAMES, help="preset of the vehicle, if the log does not show it")
    parser.add_argument(
        "--column",
        action="append",
        default=[],
        metavar="NAME=FIELD",
        help="source of a quantity: yaw_rate=r:deg/s, torque=-tau, t=stamp:ms (`incsvr inspect` lists the fields)",
    )
    parser.add_argument("--system", metavar="NAME", help="the vehicle to read, if a log contains several: 2, or rov2")
    if axis:
        parser.add_argument(
            "--axis", choices=tuple(AXES), help="axis of a whole vehicle (default: vehicle.axis, which is yaw)"
        )
    add_cut_arguments(parser)
    if config:
        parser.add_argument(
            "--config", type=Path, metavar="FILE", help="configuration whose section inputs describes the log"
        )
