"""A recording as a value: one run's streams, read as one of an axis, and runs one after the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.axes import VELOCITIES, YAW, Axis, stream_of
from incsvr.signals import REQUIRED, RUN_PAUSE_S
from service.inputs.column_spec import split_file
from service.inputs.table import ROWS
from service.logs.log import Log

Streams = dict[str, tuple[Array, Array]]


@dataclass(frozen=True, slots=True)
class Recording:
    """One run.

    Attributes:
        name: what people call it: the file's name.
        time: (n,) stamps [s], strictly increasing, not negative.
        columns: "yaw_rate" [rad/s], "torque" [N m] and further channels by name, each (n,), NaN where not sampled.
        notes: what a person should know of how it came out of a log, one sentence each.
        axis: whose velocity and force "yaw_rate" and "torque" are.
        displaced: of another axis than yaw the vehicle's own yaw rate, torque and heading, under their names.
        places: "yaw_rate" and "torque" → where they stand in the log, as a person types it behind `--column NAME=`;
            without those that no column holds, and empty where the log has our own names.
        units: SI units of the channels that came with a unit.
    """

    name: str
    time: Array
    columns: Mapping[str, Array]
    notes: tuple[str, ...] = ()
    axis: Axis = YAW
    displaced: Mapping[str, Array] = field(default_factory=dict)
    places: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)

    @property
    def channels(self) -> tuple[str, ...]:
        """The names of the channels beside yaw rate and torque."""
        return tuple(name for name in self.columns if name not in REQUIRED)

    @property
    def velocities(self) -> Mapping[str, Array]:
        """The body's other velocities that were recorded, each (n,) under its own name, NaN where not sampled."""
        rest = {name: values for name, values in self.columns.items() if name not in REQUIRED}
        recorded = {**rest, **self.displaced}
        return {name: recorded[name] for name in VELOCITIES if name in recorded and name != self.axis.rate}

    def streams(self) -> Streams:
        """Each column as a stream of its own: its stamps (m,) [s] and values (m,), without the empty cells."""
        turning = {stream_of(self.axis, YAW.rate): self.displaced[YAW.rate]} if YAW.rate in self.displaced else {}
        columns = {**self.columns, **turning}
        sampled = {name: ~np.isnan(values) for name, values in columns.items()}
        return {name: (self.time[sampled[name]], values[sampled[name]]) for name, values in columns.items()}

    def body_streams(self) -> Streams:
        """Each column as a stream of its own, velocities and efforts under the names of the body."""
        own = dict(zip(REQUIRED, own_columns(self.axis), strict=True))
        columns = {own.get(name, name): values for name, values in self.columns.items()}
        return replace(self, columns={**columns, **self.displaced}, axis=YAW, displaced={}).streams()


def of_axis(recording: Recording, axis: Axis) -> Recording:
    """The recording of a whole vehicle, read as one of this axis."""
    if axis == YAW:
        return recording
    columns = dict(recording.columns)
    displaced = {name: columns.pop(name) for name in (*REQUIRED, "heading") if name in columns}
    every = {**columns, **displaced}
    own = dict(zip(REQUIRED, (every[name] for name in own_columns(axis)), strict=True))
    rest = {name: values for name, values in columns.items() if name not in own_columns(axis)}
    away = {name: values for name, values in displaced.items() if name not in own_columns(axis)}
    return replace(recording, columns={**own, **rest}, axis=axis, displaced=away)


def own_columns(axis: Axis) -> tuple[str, str]:
    """The columns of the velocity and of what the actuators apply."""
    return axis.rate, axis.effort


def from_streams(name: str, streams: Mapping[str, tuple[Array, Array]]) -> Recording:
    """A recording of streams with stamps of their own: name → (stamps [s], strictly increasing, values)."""
    time = np.unique(np.concatenate([stamps for stamps, _ in streams.values()]))
    columns = {}
    for column, (stamps, values) in streams.items():
        columns[column] = np.full(time.size, np.nan)
        columns[column][np.searchsorted(time, stamps)] = values
    return Recording(name, time, columns)


def sequence(runs: Sequence[Recording]) -> Recording:
    """The runs one after the other as one recording, RUN_PAUSE_S apart, so that no sample reaches across two of them.

    The first keeps its time; the others are moved behind it.
    """
    times = [runs[0].time]
    for run in runs[1:]:
        times.append(run.time - run.time[0] + (float(times[-1][-1]) + RUN_PAUSE_S))
    return _one_after_the_other(runs, np.concatenate(times))


def continuation(runs: Sequence[Recording]) -> Recording:
    """Runs of one clock that follow one another, as one recording that keeps their time."""
    joined = _one_after_the_other(runs, np.concatenate([run.time for run in runs]))
    new = np.concatenate(([True], np.diff(joined.time) > 0.0))  # a row that ends one run and begins the next
    columns, displaced = (
        {name: values[new] for name, values in part.items()} for part in (joined.columns, joined.displaced)
    )
    notes = tuple(dict.fromkeys(note for run in runs for note in run.notes))
    return replace(joined, time=joined.time[new], columns=columns, displaced=displaced, notes=notes)


def _one_after_the_other(runs: Sequence[Recording], time: Array) -> Recording:
    columns, displaced = (
        {
            name: np.concatenate(
                [part.get(name, np.full(run.time.size, np.nan)) for part, run in zip(parts, runs, strict=True)]
            )
            for name in dict.fromkeys(name for part in parts for name in part)
        }
        for parts in ([run.columns for run in runs], [run.displaced for run in runs])
    )
    name = " + ".join(run.name for run in runs)
    return Recording(name, time, columns, axis=runs[0].axis, displaced=displaced)


_AWAY = "other."
"""Begins the name of a stream of another axis while it is read, where it would be called as this axis's own."""


def column_of_axis(text: str, axis: Axis) -> str:
    """The columns of an axis's own velocity and force, under the two names of a log, yaw_rate and torque."""
    file, rest = split_file(text)
    name, mark, where = rest.partition("=")
    if axis == YAW or not mark:
        return text
    own = {axis.rate: YAW.rate, axis.effort: YAW.effort}
    prefix = f"{file}:" if file else ""
    return f"{prefix}{own.get(name, _AWAY + name if name in (YAW.rate, YAW.effort) else name)}={where}"


def with_own_columns(path: Path, log: Log, columns: Sequence[str], axis: Axis) -> tuple[str, ...]:
    """The declared columns, and those of a table that have the axis's own names.

    Raises:
        BadInput: the velocity or the force of the axis is neither said nor there, and how to say it.
    """
    said = {text.partition("=")[0] for text in columns}
    there = {field for topic in log.topics if topic.name == ROWS for field in topic.fields}
    found, absent = list(columns), []
    for name, own in ((YAW.rate, axis.rate), (YAW.effort, axis.effort)):
        if name in said:
            continue
        if own in there:
            found.append(f"{name}={own}")
        else:
            absent.append(own)
    if absent:
        flags = " ".join(f"--column {own}=NAME" for own in absent)
        names = {axis.rate: f"{axis.name} {'velocity' if axis.along else 'rate'}", axis.effort: axis.effort}
        called = " and no ".join(names[own].replace("_", " ") for own in absent)
        raise BadInput(f"{path}: no {called} found; add {flags} (`incsvr inspect {path}` lists the names)")
    return tuple(found)


def put_back(recording: Recording, axis: Axis) -> Recording:
    """A log's recording, the streams of other axes under their own names again."""
    if axis == YAW:
        return recording
    columns = {name: values for name, values in recording.columns.items() if not name.startswith(_AWAY)}
    columns.pop("heading", None)
    away = {n.removeprefix(_AWAY): values for n, values in recording.columns.items() if n.startswith(_AWAY)}
    return replace(recording, columns=columns, axis=axis, displaced=away)
