"""A log read as one of another axis than yaw: its own velocity and force under the two names that a log is read by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from incsvr.errors import BadInput
from incsvr.plant.axes import YAW, Axis
from service.inputs.table import ROWS
from service.logs.log import Log
from service.recordings.recording import Recording

_AWAY = "other."
"""Begins the name of a stream of another axis while it is read, where it would be called as this axis's own."""


def of_axis(text: str, axis: Axis) -> str:
    """The columns of an axis's own velocity and force, under the two names of a log, yaw_rate and torque."""
    name, mark, where = text.partition("=")
    if axis == YAW or not mark:
        return text
    own = {axis.rate: YAW.rate, axis.effort: YAW.effort}
    return f"{own.get(name, _AWAY + name if name in (YAW.rate, YAW.effort) else name)}={where}"


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
