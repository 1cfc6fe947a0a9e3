"""A manoeuvre as a file: what the tracer advises to drive next, for a vehicle or `incsvr simulate --torque` to play.

A CSV file with the columns `t` [s] and `torque` [N m]; each torque holds until the next row, and the last row ends the
manoeuvre.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.tracing.findings import Finding
from service.cli.output import writing

Profile = tuple[Array, Array]


def next_manoeuvre(effects: Sequence[Finding], path: Path) -> str:
    """Writes the first manoeuvre that a trace advises, and says what was written, or why nothing was."""
    for finding in effects:
        if finding.manoeuvre:
            write_manoeuvre(path, finding.manoeuvre)
            lasts = f"{finding.manoeuvre[-1][0]:.4g} s long"
            return (
                f"{path} contains the manoeuvre that distinguishes {finding.effect} from "
                f"{finding.cannot_tell_from[0]}, {lasts}"
            )
    if any(finding.cannot_tell_from for finding in effects):
        return f"{path} is not written: no manoeuvre distinguishes the explanations"
    return f"{path} is not written: no finding needs another manoeuvre"


def write_manoeuvre(path: Path, rows: Sequence[tuple[float, float]]) -> None:
    """Writes the file.

    Raises:
        BadInput: it cannot be written.
    """
    with writing(path), path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["t", "torque"])
        writer.writerows(rows)


def read_manoeuvre(path: Path) -> Profile:
    """The stamps (n,) [s] and torques (n,) [N m] of a file.

    Raises:
        BadInput: naming the file, the row (the header is row 1) and the cure.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = list(csv.reader(file))
    except FileNotFoundError:
        raise BadInput(f"{path}: there is no such file; `incsvr trace LOG --manoeuvre FILE.csv` writes one") from None
    except (OSError, UnicodeDecodeError, csv.Error):
        raise BadInput(f"{path}: this is no CSV text; give a file with the columns t,torque") from None
    header = [name.strip() for name in rows[0]] if rows else []
    if any(name not in header for name in ("t", "torque")):
        raise BadInput(f"{path}, row 1: a manoeuvre has the columns t [s] and torque [N m]; name them so")
    places = [header.index(name) for name in ("t", "torque")]
    numbers = [_pair(path, number, row, places) for number, row in enumerate(rows[1:], start=2) if any(row)]
    if len(numbers) < 2:
        raise BadInput(f"{path}: a manoeuvre has at least two rows, of which the last one ends it")
    time, torque = np.array(numbers).T
    backwards = np.flatnonzero(np.diff(time) <= 0.0)
    if backwards.size:
        raise BadInput(
            f"{path}, row {backwards[0] + 3}: t does not increase after {time[backwards[0]]:g} s; sort the rows"
        )
    return time, torque


def _pair(path: Path, number: int, row: Sequence[str], places: Sequence[int]) -> tuple[float, float]:
    try:
        time, torque = (float(row[place]) for place in places)
    except (ValueError, IndexError):
        time = torque = math.nan
    if not (math.isfinite(time) and math.isfinite(torque)):
        raise BadInput(f"{path}, row {number}: t and torque must be two numbers; correct the row, or remove it")
    return time, torque
