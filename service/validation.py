"""Validation data: damping samples that the learner never learns from, read once at the start."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from incsvr.errors import BadInput
from incsvr.samples import Samples

COLUMNS = ("yaw_rate", "damping")


def read_validation(path: Path) -> Samples:
    """The samples in a CSV file with the columns yaw_rate [rad/s] and damping [N m]; further columns are ignored.

    Raises:
        BadInput: naming the file, the row and the cure.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = list(csv.DictReader(file))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise BadInput(f"{path}: cannot be read as CSV ({error})") from None
    if not rows or any(name not in rows[0] for name in COLUMNS):
        raise BadInput(
            f"{path}: validation data has the columns yaw_rate [rad/s] and damping [N m] and at least one row"
        )
    values = []
    for number, row in enumerate(rows, start=2):
        try:
            values.append([float(row[name]) for name in COLUMNS])
        except (TypeError, ValueError):
            raise BadInput(
                f"{path}, row {number}: yaw_rate and damping must be numbers; correct or remove it"
            ) from None
    rate, damping = np.array(values).T
    beyond = np.flatnonzero(~np.isfinite(rate + damping))
    if beyond.size:
        raise BadInput(f"{path}, row {beyond[0] + 2}: yaw_rate and damping must be finite; correct or remove it")
    return Samples(np.arange(rate.size, dtype=np.float64), rate, damping)
