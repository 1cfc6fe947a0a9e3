"""Recordings: CSV files of one contiguous run each, read with every fault named, and written exactly.

Header row; `t` [s], never going back; `yaw_rate` [rad/s]; `torque` [N m]; then any further numeric channels. An
empty cell (also `nan`, `NA`) means that the channel was not sampled in that row, so streams of different rates fit in
one file. Rows of one instant are merged.

Of another axis than yaw its own columns (`sway`, `sway_force`) stand for these two.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from math import nan
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.axes import EFFORTS, YAW, Axis
from incsvr.plant.words import words_of
from incsvr.signals.steps import refuse_steps
from incsvr.signals.streams import MAX_STAMP_S
from service.inputs.clocks import set_at, without_leaps
from service.inputs.marks import all_without_marks
from service.logs.cells import EMPTY_CELLS
from service.logs.csv_log import csv_rows
from service.logs.cutting import WHOLE_LOG, Cut, Span, columns_inside, rows_inside, since_1970
from service.number import number_of
from service.recordings.log_refusals import refuse_whole_numbers
from service.recordings.recording import Recording

RATE_LIMIT = YAW.fastest
"""Largest plausible yaw rate [rad/s], about one turn a second: beyond, the column is probably in degrees per second."""
MAX_TYPICAL_STEP_S = 2.0
"""Longest plausible typical time step [s]: beyond, the stamps are probably milliseconds."""


def write(path: Path, recording: Recording) -> None:
    """Writes a CSV file from which `read` gives the same numbers to the last bit."""
    columns = [recording.time.tolist(), *(values.tolist() for values in recording.columns.values())]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["t", *recording.columns])
        writer.writerows(["" if cell != cell else repr(cell) for cell in row] for row in zip(*columns, strict=True))


def read(
    path: Path, *, rate_limit: float = RATE_LIMIT, limit_is: str = "", axis: Axis = YAW, cut: Cut = WHOLE_LOG
) -> Recording:
    """The recording in a CSV file.

    Args:
        path: the file.
        axis: which is meant.
        rate_limit: largest plausible magnitude of the yaw rate [rad/s].
        limit_is: what the user may raise it by, if there is such a thing.
        cut: the part of it that is taken.

    Raises:
        EmptyCut: the cut holds none of its rows.
        BadInput: naming the file, the row (the header is row 1) and the cure.
    """
    header, lines = _rows(path, axis)
    cells = list(zip(*lines, strict=True))
    columns = {name: _numbers(path, name, column) for name, column in zip(header, cells, strict=True)}
    time = columns.pop("t")
    _check_time(path, time)
    time, sets = without_leaps(time)
    rows = np.arange(time.size) + 2
    if cut:
        span = Span(float(time[0]), float(time[-1]), since_1970(time, None))
        try:
            inside = rows_inside(time, cut, span)
        except BadInput as error:
            raise type(error)(f"{path}: {error}") from None
        time, rows, columns = time[inside], rows[inside], columns_inside(columns, inside)
    rate = axis.rate
    for name in (rate, axis.effort):
        if np.isnan(columns[name]).all():
            where = f" in the part that {cut} takes" if cut else ""
            raise BadInput(f"{path}: the column {name} is empty{where}; it must hold the {_unit(axis, name)}")
    columns, marks = all_without_marks(columns, EFFORTS)
    refuse_whole_numbers(path, columns[rate], rate, rate)
    beyond = np.flatnonzero(np.abs(columns[rate]) > rate_limit)
    if beyond.size:
        faster = f"; if the vehicle really turns so fast, raise {limit_is}" if limit_is else ""
        degrees = f"; if it is in degrees per second, give the unit: --column {rate}={rate}:deg/s" * (not axis.along)
        raise BadInput(
            f"{path}, row {rows[beyond[0]]}: {rate} is {columns[rate][beyond[0]]:g}, beyond the plausible "
            f"±{rate_limit:g} {'m/s' if axis.along else 'rad/s'}{degrees}{faster}"
        )
    for name, values in columns.items():
        refuse_steps(time[~np.isnan(values)], f"{path}: the times of {name}")
    notes = (*(set_at(at) for at in sets), *marks)
    return Recording(path.name, *_merged(path, time, columns, rows), notes, axis)


def _unit(axis: Axis, column: str) -> str:
    """The quantity and unit of a column."""
    words = words_of(axis)
    if column == "t":
        return "time [s]"
    if column == axis.rate:
        return f"{words.rate} [{words.rate_unit}]"
    return f"{words.name} {words.moment} of the actuators [{words.effort_unit}]"


def _rows(path: Path, axis: Axis) -> tuple[list[str], list[list[str]]]:
    """Header and rows, all of the header's length."""
    rows = csv_rows(path, ",")
    while rows and not any(rows[-1]):
        rows.pop()
    if not rows:
        raise BadInput(f"{path}: the file is empty; a recording begins with the header t,yaw_rate,torque")
    header = [name.strip() for name in rows[0]]
    _check_header(path, header, axis)
    if len(rows) == 1:
        raise BadInput(f"{path}: there are no rows below the header; record at least a few seconds")
    for number, row in enumerate(rows[1:], start=2):
        if len(row) != len(header):
            raise BadInput(
                f"{path}, row {number}: {len(row)} cells under a header of {len(header)}; "
                "leave a cell empty where nothing was sampled, but keep its comma"
            )
    return header, rows[1:]


def _check_header(path: Path, header: Sequence[str], axis: Axis) -> None:
    for name in ("t", axis.rate, axis.effort):
        if name not in header:
            raise BadInput(
                f"{path}, row 1: there is no column {name} among {', '.join(header)}; "
                f"name the column with the {_unit(axis, name)} {name}"
            )
    for position, name in enumerate(header):
        if not name or name in header[:position]:
            raise BadInput(
                f"{path}, row 1: column {position + 1} is named {name!r}; give every column a name of its own"
            )


def _numbers(path: Path, name: str, cells: Sequence[str]) -> Array:
    """A column as numbers, NaN for cells in whose place nothing was sampled."""
    try:
        values = np.array([number_of(cell) if cell else nan for cell in cells])
    except ValueError:
        values = np.array([_number(path, name, row, cell) for row, cell in enumerate(cells, start=2)])
    for row in np.flatnonzero(~np.isfinite(values)):
        if cells[row].strip().lower() not in EMPTY_CELLS:
            raise BadInput(
                f"{path}, row {row + 2}: {name} is {cells[row].strip()!r}; "
                "leave the cell empty where nothing was sampled, or remove the row"
            )
    return values


def _number(path: Path, name: str, row: int, cell: str) -> float:
    try:
        return nan if cell.strip().lower() in EMPTY_CELLS else number_of(cell)
    except ValueError:
        raise BadInput(
            f"{path}, row {row}: {name} is {cell.strip()!r}, which is no number; "
            "correct it, or leave the cell empty where nothing was sampled"
        ) from None


def _check_time(path: Path, time: Array) -> None:
    missing = np.flatnonzero(np.isnan(time))
    if missing.size:
        raise BadInput(f"{path}, row {missing[0] + 2}: t is empty; every row needs its time [s]")
    if time[0] < 0.0:
        raise BadInput(f"{path}, row 2: t is {time[0]:g}; let time begin at zero or later")
    steps = np.diff(time)
    backwards = np.flatnonzero(steps < 0.0)
    if backwards.size:
        row = backwards[0] + 3
        raise BadInput(
            f"{path}, row {row}: time runs backwards, from {time[row - 3]:.10g} to {time[row - 2]:.10g} s; "
            "sort the rows by t, and put each run into a file of its own"
        )
    typical = float(np.median(steps[steps > 0.0])) if steps.any() else 0.0
    if typical > MAX_TYPICAL_STEP_S:
        raise BadInput(
            f"{path}, row 3: t advances by {typical:g} in a typical row; "
            "if the stamps are milliseconds, divide them by 1000"
        )
    if time[-1] >= MAX_STAMP_S:
        raise BadInput(
            f"{path}, row {time.size + 1}: t is {time[-1]:g}, which is no time in seconds; convert the stamps"
        )


def _merged(
    path: Path, time: Array, columns: Mapping[str, Array], rows: NDArray[np.int_]
) -> tuple[Array, dict[str, Array]]:
    """One row an instant: of rows with the same stamp each gives what it has, as where two topics were joined."""
    instants, place = np.unique(time, return_inverse=True)
    if instants.size == time.size:
        return time, dict(columns)
    merged = {}
    for name, values in columns.items():
        merged[name] = np.full(instants.size, np.nan)
        sampled = np.flatnonzero(~np.isnan(values))
        merged[name][place[sampled]] = values[sampled]
        other = sampled[merged[name][place[sampled]] != values[sampled]]
        if other.size:
            raise BadInput(
                f"{path}, row {rows[other[0]]}: t is {time[other[0]]:.10g} in several rows, with different values of "
                f"{name}; leave one of them"
            )
    return instants, merged
