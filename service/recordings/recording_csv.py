"""Recordings: CSV files of one contiguous run each, read with every fault of a row named, and written exactly.

Header row; `t` [s], never going back; `yaw_rate` [rad/s]; `torque` [N m]; then any further numeric channels. An
empty cell (also `nan`, `NA`) means that the channel was not sampled in that row, so streams of different rates fit in
one file. Rows of one instant are merged. Of another axis than yaw its own columns (`sway`, `sway_force`) stand for
these two.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from math import nan
from pathlib import Path

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.axes import YAW, Axis
from incsvr.signals.streams import MAX_STAMP_S
from service.inputs.table import Table
from service.logs.cells import EMPTY_CELLS
from service.logs.csv_log import OURS, csv_rows, refuse_unnamed
from service.logs.log import Log, table_log
from service.number import number_of
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


def open_recording(path: Path, axis: Axis) -> Log:
    """The table in a CSV file that begins as our recordings of an axis do.

    Raises:
        BadInput: naming the file, the row (the header is row 1) and the cure.
    """
    header, lines = _rows(path)
    columns = {name: _numbers(path, name, cells) for name, cells in zip(header, zip(*lines, strict=True), strict=True)}
    _check_time(path, columns["t"])
    _check_instants(path, columns)
    return table_log(OURS, Table(None, columns, {}))


def _rows(path: Path) -> tuple[list[str], list[list[str]]]:
    """Header and rows, all of the header's length."""
    rows = csv_rows(path, ",")
    while rows and not any(rows[-1]):
        rows.pop()
    header = [name.strip() for name in rows[0]]
    refuse_unnamed(path, header)
    if len(rows) == 1:
        raise BadInput(f"{path}: there are no rows below the header; record at least a few seconds")
    for number, row in enumerate(rows[1:], start=2):
        if len(row) != len(header):
            raise BadInput(
                f"{path}, row {number}: {len(row)} cells under a header of {len(header)}; "
                "leave a cell empty where nothing was sampled, but keep its comma"
            )
    return header, rows[1:]


def _numbers(path: Path, name: str, cells: Sequence[str]) -> Array:
    """A column as numbers, NaN for cells in whose place nothing was sampled."""
    try:
        number = number_of if "_" in "".join(cells) else float  # of a million cells, each call counts
        values = np.array([number(cell) if cell else nan for cell in cells])
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


def _check_instants(path: Path, columns: Mapping[str, Array]) -> None:
    """Refuses rows of one stamp with different values: of such rows each gives what it has, as where two topics were
    joined."""
    time = columns["t"]
    again = np.flatnonzero(np.diff(time) == 0.0) + 1
    if not again.size:
        return
    _, first, place = np.unique(time, return_index=True, return_inverse=True)
    for name, values in columns.items():
        sampled = np.flatnonzero(~np.isnan(values))
        kept = np.zeros(first.size)
        kept[place[sampled]] = values[sampled]
        other = sampled[kept[place[sampled]] != values[sampled]]
        if other.size:
            raise BadInput(
                f"{path}, row {other[0] + 2}: t is {time[other[0]]:.10g} in several rows, with different values of "
                f"{name}; leave one of them"
            )
