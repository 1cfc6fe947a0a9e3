"""Faults of a table that is a recording of our own, each named with its row and its cure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.axes import Axis
from incsvr.signals.streams import MAX_STAMP_S
from service.inputs.units import QUANTITY_NAMES
from service.logs.cells import EMPTY_CELLS, Columns, plain_number
from service.logs.opening import first_bytes

MAX_TYPICAL_STEP_S = 2.0
"""Longest plausible typical time step [s]: beyond, the stamps are probably milliseconds."""


def is_ours(path: Path, axis: Axis) -> bool:
    """Whether the file begins as our recordings of an axis do, which are read with every fault named by its row."""
    if path.is_dir() or not path.exists():
        return False
    first_bytes(path)
    with path.open("rb") as file:
        header = file.readline(100_000).lstrip(b"\xef\xbb\xbf")
    return {"t", axis.rate, axis.effort} <= {name.strip() for name in header.decode(errors="replace").split(",")}


def refuse_faults(path: Path, header: Sequence[str], rows: Sequence[Sequence[str]], found: Columns) -> None:
    """Refuses what no recording of our own holds.

    Args:
        rows: of the file, the header first.
        found: what they hold.

    Raises:
        BadInput: naming the file, the row (the header is row 1) and the cure.
    """
    last = max(number for number, row in enumerate(rows, start=1) if any(row))
    for number, row in enumerate(rows[1:last], start=2):
        if len(row) != len(header):
            raise BadInput(
                f"{path}, row {number}: {len(row)} cells under a header of {len(header)}; "
                "leave a cell empty where nothing was sampled, but keep its comma"
            )
        if not any(row):
            raise BadInput(f"{path}, row {number}: t is empty; every row needs its time [s]")
    for place, name in enumerate(header):
        infinite = np.isinf(found.numbers.get(name, np.empty(0)))
        if not infinite.any() and name in found.numbers and name not in found.instants:
            continue
        words = name in found.texts and name not in QUANTITY_NAMES
        if words and not any(plain_number(cell) is not None for cell in found.texts[name] if cell):
            continue  # of a mode, or of remarks: nobody takes it for a channel
        for number, row in enumerate(rows[1:last], start=2):
            cell = row[place].strip()
            if (value := plain_number(cell)) is None:
                raise BadInput(
                    f"{path}, row {number}: {name} is {cell!r}, which is no number; "
                    "correct it, or leave the cell empty where nothing was sampled"
                )
            if not np.isfinite(value) and cell.lower() not in EMPTY_CELLS:
                raise BadInput(
                    f"{path}, row {number}: {name} is {cell!r}; "
                    "leave the cell empty where nothing was sampled, or remove the row"
                )
    _refuse_time(path, found.numbers["t"])
    _refuse_instants(path, found.numbers)


def _refuse_time(path: Path, time: Array) -> None:
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


def _refuse_instants(path: Path, columns: Mapping[str, Array]) -> None:
    """Refuses rows of one stamp with different values: of such rows each gives what it has, as where two topics were
    joined."""
    time = columns["t"]
    if not (np.diff(time) == 0.0).any():
        return
    _, first, place = np.unique(time, return_index=True, return_inverse=True)
    for name, values in columns.items():
        sampled = np.flatnonzero(~np.isnan(values))
        kept = np.zeros(first.size)
        kept[place[sampled]] = values[sampled]
        other = sampled[kept[place[sampled]] != values[sampled]]
        if other.size:
            raise BadInput(
                f"{path}, row {other[0] + 2}: t is {time[other[0]]:.10g} in several rows, with different values "
                f"of {name}; leave one of them"
            )
