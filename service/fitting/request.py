"""What a person asks of logs: which they are, what is in them, and what is declared of the vehicle.

In Python these are keywords, at a command line flags; both make the same `Request`, and the same functions take it.
"""

from __future__ import annotations

import argparse
from collections.abc import Collection, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from itertools import groupby
from pathlib import Path
from typing import Any

from incsvr.errors import BadInput
from incsvr.plant.axes import AXES, YAW, Axis
from incsvr.signals.settings import TorqueKind
from service.cli.next_command import following
from service.cli.parser import one_of
from service.config.configuration import Config, merge, validate
from service.config.sources import read as read_config
from service.config.sources import set_values
from service.config.vehicle_file import read_vehicle
from service.config.vehicle_learners import body_of
from service.fitting.arrays import Arrays
from service.inputs.table import ROWS
from service.logs import open_any
from service.logs.cutting import Instant
from service.logs.reading import LogDescription, describe
from service.recordings.reading import Reading
from service.recordings.recording import Recording

POLICIES = ("paper", "weighted")
"""The policies that select the samples to keep."""
Source = Path | Arrays
"""A log: a file, or arrays by the names of their columns."""


@dataclass(frozen=True, slots=True)
class Request:
    """The logs, and all that a person may say of them; each function uses what concerns it.

    Attributes:
        recordings: what is learned from.
        validate: what is not learned, for the errors alone.
        config: a configuration file.
        vehicle: a vehicle file, whose mass matrix is declared.
        set: values of the configuration, NAME=VALUE.
        inertia: a number [kg m²], [kg], or "estimate"; None as configured.
        axis: its name; None as configured.
        preset, column, system: what is in the logs.
        cut_from, cut_to: the part of `recordings` that is used.
        effects: a result of `incsvr trace --json FILE`.
        policy: which samples are kept; None as configured.
        assume_sign: the torque's sign is taken as it is.
        name: what the vehicle is called.
    """

    recordings: tuple[Source, ...]
    validate: tuple[Source, ...] = ()
    config: Path | None = None
    vehicle: Path | None = None
    set: tuple[str, ...] = ()
    inertia: str | None = None
    axis: str | None = None
    preset: str | None = None
    column: tuple[str, ...] = ()
    system: str | None = None
    cut_from: Instant | None = None
    cut_to: Instant | None = None
    effects: Path | None = None
    policy: str | None = None
    assume_sign: bool = False
    name: str = "vehicle"

    @staticmethod
    def of(args: argparse.Namespace, recordings: str = "recordings") -> Request:
        """The request of a command's flags; `recordings` is what it calls its logs."""
        said: dict[str, Any] = {each.name: getattr(args, each.name, None) for each in fields(Request)}
        said["recordings"] = getattr(args, recordings)
        given: dict[str, Any] = {name: value for name, value in said.items() if value is not None}
        frozen: dict[str, Any] = {name: tuple(it) if isinstance(it, list) else it for name, it in given.items()}
        return Request(**frozen)

    def read(self, reading: Reading) -> tuple[list[Recording], list[Recording]]:
        """What is learned from, and what is not, a recording each dive.

        Raises:
            BadInput: one cannot be read.
        """
        return read_each(reading, self.recordings), read_each(reading.whole, self.validate)

    def reading(self, config: Config) -> Reading:
        """The settings by which its logs are read."""
        return Reading.of(self, config)

    def values_set(self, takes: Collection[str]) -> tuple[dict[str, Any], dict[tuple[str, ...], str]]:
        """The values that are set, nested, and the flag that each came from.

        Raises:
            BadInput: one is none of those that the function `takes`.
        """
        flags, origin = set_values(self.set)
        for place, flag in origin.items():
            if not any(place[: name.count(".") + 1] == tuple(name.split(".")) for name in takes):
                raise BadInput(f"{flag}: this command uses values of {one_of(tuple(takes))} alone; leave it out")
            if len(place) == 1:
                raise BadInput(f"{flag}: name one value of the section, as `incsvr config show` lists them")
            if place == ("vehicle", "axis"):
                raise BadInput(f"{flag}: give the axis by --axis")
        return flags, origin

    def configured(self, takes: Collection[str], base: Config | None = None) -> Config:
        """The configuration of one learner: that of the file, or `base`, and over it what is declared here.

        Raises:
            BadInput: naming what is wrong, and what is allowed there.
        """
        config = read_config(self.config).of_axis(self.axis) if base is None else base
        flags, origin = self.values_set(takes)
        axis = self.axis or config.vehicle.axis
        if self.vehicle is not None:
            flags = merge({"vehicle": body_of(read_vehicle(self.vehicle), axis)}, flags)
        if not flags:
            return config
        values = config.model_dump(exclude_unset=True)
        vehicle, signals = (values.setdefault(name, {}) for name in ("vehicle", "signals"))
        if flags.get("vehicle", {}).get("mass_matrix") is not None:
            vehicle.pop("inertia", None)  # the mass matrix says it
        width = flags.get("signals", {}).get("smoothing")
        if isinstance(width, int | float) and signals.get("gap") is not None:
            signals["gap"] = min(signals["gap"], 2.0 * width)  # a narrower filter bridges no longer pauses than it may
        return validate(merge(values, merge(flags, {"vehicle": {"axis": axis}})), origin)

    def torque_set(self, config: Config) -> TorqueKind | None:
        """What the torque is, where `set` says it."""
        return config.signals.torque if "torque" in self.names_set("signals") else None

    def names_set(self, section: str) -> frozenset[str]:
        """The names of a section of the configuration that are set."""
        return frozenset(set_values(self.set)[0].get(section, {}))

    def following(
        self, command: str, flags: Iterable[str], *more: str, files: Sequence[Source] | None = None
    ) -> str | None:
        """The command over the same files that follows; None where arrays are no file."""
        named = self.recordings if files is None else files
        if any(isinstance(each, Arrays) for each in (*self.recordings, *self.validate)):
            return None
        return following(self, command, [str(each) for each in named], flags, *more)


def read_each(reading: Reading, sources: Sequence[Source]) -> list[Recording]:
    """Each dive as a recording, in the order in which they were given."""
    found: list[Recording] = []
    for of_files, group in groupby(sources, key=lambda each: isinstance(each, Path)):
        if of_files:
            found += reading.of_all([each for each in group if isinstance(each, Path)])
        else:
            found += [reading.of_one(Path(each.name), each.log) for each in group if isinstance(each, Arrays)]
    return found


def read_body(reading: Reading, sources: Sequence[Source]) -> list[Recording]:
    """Each dive as a recording; a table without yaw rate or torque as one of an axis whose own columns it has.

    Raises:
        BadInput: one cannot be read.
    """
    try:
        return read_each(reading, sources)
    except BadInput:
        axis = None
        with suppress(BadInput):  # the first refusal says more than one of a second look
            axis = _axis_without_yaw(sources[0], reading.description)
        if axis is None:
            raise
    return read_each(replace(reading, axis=axis, rate_limit=axis.fastest), sources)


def _axis_without_yaw(source: Source, description: LogDescription) -> Axis | None:
    """The first axis whose velocity and effort are columns of a table that lacks yaw rate or torque; None without."""
    log = source.log if isinstance(source, Arrays) else open_any(source)
    said = description.of(source.name)
    if not {YAW.rate, YAW.effort} & describe(log, said).missing.keys():
        return None
    there = {field for topic in log.topics if topic.name == ROWS for field in topic.fields}
    there |= {text.partition("=")[0] for text in said.columns}
    return next((axis for axis in AXES.values() if axis != YAW and {axis.rate, axis.effort} <= there), None)
