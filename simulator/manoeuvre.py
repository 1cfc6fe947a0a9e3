"""A manoeuvre as a file: what the tracer advises to drive next, for a vehicle or `incsvr simulate --torque` to play.

A CSV file with the columns `t` [s] and `torque` [N m]; each torque holds until the next row, and the last row ends the
manoeuvre. The tracer tells a manoeuvre in words, in one of four shapes. They are read here, so that the file holds what
the sentence says, to the digit.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from incsvr.errors import BadInput
from incsvr.samples import Array
from incsvr.tracing.findings import Finding

ROWS_A_PERIOD = 40
"""Rows in the shortest period of a sine: held values then err by at most 8 % of its height."""
STAIRS = (0.25, 0.0, -0.25, 0.5, 0.0, -0.5, 1.0, 0.0, -1.0, 0.75, 0.1, -0.75, -0.1)
"""Of the torque that the words name, one step after the other."""
_NUMBER = r"([-+0-9.e]+)"
_UNIT = r"(?: N m| N)"

Profile = tuple[Array, Array]


def profile_of(words: str) -> Profile | None:
    """The manoeuvre that a sentence of the tracer tells: (n,) stamps [s] and torques [N m]; None where it tells none.

    >>> time, torque = profile_of("drive steps between ±6 N m every 2 s for 8 s: expected evidence 2Δℓ ≈ 40")
    >>> time.tolist(), torque.tolist()
    ([0.0, 2.0, 4.0, 6.0, 8.0], [6.0, -6.0, 6.0, -6.0, 0.0])
    """
    for pattern, shape in _SHAPES:
        if found := re.search(pattern, words):
            return shape(*(float(number) for number in found.groups()))
    return None


def _steps(top: float, hold: float, length: float) -> Profile:
    count = max(1, round(length / hold))
    return _ended(np.arange(count) * hold, top * np.where(np.arange(count) % 2, -1.0, 1.0), count * hold)


def _stairs(top: float, hold: float) -> Profile:
    count = len(STAIRS)
    return _ended(np.arange(count) * hold, top * np.array(STAIRS), count * hold)


def _sine(top: float, period: float, length: float) -> Profile:
    time = np.arange(0.0, length, period / ROWS_A_PERIOD)
    return _ended(time, top * np.sin(2.0 * math.pi * time / period), length)


def _sweep(top: float, slowest: float, fastest: float, length: float) -> Profile:
    """A sine whose frequency [Hz] rises evenly."""
    time = np.arange(0.0, length, fastest / ROWS_A_PERIOD)
    turns = time / slowest + 0.5 * time**2 / length * (1.0 / fastest - 1.0 / slowest)
    return _ended(time, top * np.sin(2.0 * math.pi * turns), length)


_SHAPES: Sequence[tuple[str, Callable[..., Profile]]] = (
    (rf"steps between ±{_NUMBER}{_UNIT} every {_NUMBER} s for {_NUMBER} s", _steps),
    (rf"stairs of 25, 50, 75 and 100 % of {_NUMBER}{_UNIT} both ways, with rests, {_NUMBER} s each", _stairs),
    (rf"a sine of {_NUMBER}{_UNIT} and {_NUMBER} s for {_NUMBER} s", _sine),
    (rf"a sweep of {_NUMBER}{_UNIT} from {_NUMBER} s to {_NUMBER} s period in {_NUMBER} s", _sweep),
)


def _ended(time: NDArray[np.floating], torque: NDArray[np.floating], end: float) -> Profile:
    """The same with a last row at which nothing is asked any more."""
    return np.append(time, end).astype(np.float64), np.append(torque, 0.0).astype(np.float64)


def next_manoeuvre(effects: Sequence[Finding], path: Path) -> str:
    """Writes the first manoeuvre that a trace advises, and says what was written, or why nothing was."""
    for finding in effects:
        profile = profile_of(finding.next_manoeuvre)
        if profile is not None:
            write_manoeuvre(path, profile)
            rivals = ", ".join(finding.cannot_tell_from)
            return f"{path} holds the manoeuvre that tells {finding.effect} from {rivals}, {profile[0][-1]:.4g} s long"
    if any(finding.cannot_tell_from for finding in effects):
        return f"{path} is not written: no manoeuvre tells the explanations apart"
    return f"{path} is not written: nothing was found that another manoeuvre would have to tell from something else"


def write_manoeuvre(path: Path, profile: Profile) -> None:
    """Writes the file.

    Raises:
        BadInput: it cannot be written.
    """
    rows = zip(*(values.round(4).tolist() for values in profile), strict=True)
    try:
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["t", "torque"])
            writer.writerows(rows)
    except OSError as error:
        raise BadInput(f"{path} cannot be written ({error.strerror}); name another file") from error


def read_manoeuvre(path: Path) -> Profile:
    """What a file says: (n,) stamps [s] and torques [N m].

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
        raise BadInput(f"{path}, row {backwards[0] + 3}: t does not go on from {time[backwards[0]]:g} s; sort the rows")
    return time, torque


def _pair(path: Path, number: int, row: Sequence[str], places: Sequence[int]) -> tuple[float, float]:
    try:
        time, torque = (float(row[place]) for place in places)
    except (ValueError, IndexError):
        time = torque = math.nan
    if not (math.isfinite(time) and math.isfinite(torque)):
        raise BadInput(f"{path}, row {number}: t and torque must be two numbers; correct the row, or remove it")
    return time, torque
