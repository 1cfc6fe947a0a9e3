"""Logs read for a whole vehicle: also those that lack yaw, which are read as logs of another axis."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from incsvr.errors import BadInput
from incsvr.plant.axes import AXES, YAW, Axis
from service.inputs.table import ROWS
from service.logs import open_any
from service.logs import reading as logs
from service.logs.reading import LogDescription
from service.recordings.axis_columns import of_axis
from service.recordings.reading import Reading
from service.recordings.recording import Recording


def read_body(reading: Reading, paths: Sequence[Path]) -> list[Recording]:
    """Each dive as a recording; a table without yaw rate or torque as one of an axis whose own columns it has.

    Raises:
        BadInput: as of `Reading.of_all`.
    """
    try:
        return reading.of_all(paths)
    except BadInput:
        axis = None
        with suppress(BadInput):  # the first refusal says more than one of a second look
            axis = _axis_without_yaw(paths[0], reading.description)
        if axis is None:
            raise
    columns = tuple(of_axis(text, axis) for text in reading.description.columns)
    description = replace(reading.description, columns=columns)
    return replace(reading, axis=axis, rate_limit=axis.fastest, description=description).of_all(paths)


def _axis_without_yaw(path: Path, description: LogDescription) -> Axis | None:
    """The first axis whose velocity and effort are columns of a table that lacks yaw rate or torque; None without."""
    log = open_any(path)
    if not {YAW.rate, YAW.effort} & logs.describe(log, description).missing.keys():
        return None
    there = {field for topic in log.topics if topic.name == ROWS for field in topic.fields}
    there |= {text.partition("=")[0] for text in description.columns}
    return next((axis for axis in AXES.values() if axis != YAW and {axis.rate, axis.effort} <= there), None)
