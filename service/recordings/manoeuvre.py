"""A manoeuvre as a file, for `incsvr simulate` to play.

A CSV file with the columns `t` [s] and efforts, such as `torque` [N m] or `surge_force` [N]; each value holds until the
next row, and the last row ends the manoeuvre.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array, Streams
from incsvr.plant.axes import EFFORTS, VELOCITIES
from incsvr.signals.steps import refuse_steps
from service.logs.csv_log import csv_rows
from service.number import number_of

PLAN_STEP_S = 0.02
"""Time between two values of a plan's streams [s]: as often as a simulated vehicle is told its efforts."""


def read_plan(path: Path) -> Streams | None:
    """The efforts of a manoeuvre, each as a stream that repeats its value while it holds; None where
    the file is a log: no CSV text, or one with a velocity.

    Raises:
        BadInput: naming the file, the row (the header is row 1) and the cure.
    """
    try:
        rows = csv_rows(path) or [[]]
    except BadInput:  # what reads logs says what it is
        return None
    rows[0] = [name.strip() for name in rows[0]]
    names = [name for name in rows[0] if name in EFFORTS]
    if "t" not in rows[0] or not names or set(rows[0]) & set(VELOCITIES):
        return None
    time, *efforts = _columns(path, rows, ("t", *names)).T
    at: Array = np.arange(time[0], time[-1], PLAN_STEP_S, dtype=np.float64)
    held = np.searchsorted(time, at, side="right") - 1
    return {name: (at, values[held]) for name, values in zip(names, efforts, strict=True)}


def _columns(path: Path, rows: Sequence[Sequence[str]], names: Sequence[str]) -> Array:
    """(n, names) numbers of these columns, of which the first is the time."""
    places = [rows[0].index(name) for name in names]
    numbers = [_numbers(path, number, row, names, places) for number, row in enumerate(rows[1:], start=2) if any(row)]
    if len(numbers) < 2:
        raise BadInput(f"{path}: a manoeuvre has at least two rows, of which the last one ends it")
    columns = np.array(numbers)
    backwards = np.flatnonzero(np.diff(columns[:, 0]) <= 0.0)
    if backwards.size:
        raise BadInput(
            f"{path}, row {backwards[0] + 3}: t does not increase after {columns[backwards[0], 0]:g} s; sort the rows"
        )
    refuse_steps(columns[:, 0], f"{path}: the times")
    return columns


def _numbers(path: Path, number: int, row: Sequence[str], names: Sequence[str], places: Sequence[int]) -> list[float]:
    try:
        values = [number_of(row[place]) for place in places]
    except (ValueError, IndexError):
        values = [math.nan]
    if not all(map(math.isfinite, values)):
        called, many = " and ".join(names), "two" if len(names) == 2 else len(names)
        raise BadInput(f"{path}, row {number}: {called} must be {many} numbers; correct the row, or remove it")
    return values
