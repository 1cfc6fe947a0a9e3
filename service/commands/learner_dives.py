"""`incsvr compare --from-learner`: the dives that learners remember, compared without their logs."""

from __future__ import annotations

import sqlite3
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import t as student

from incsvr.errors import BadInput
from incsvr.plant.axes import AXES
from incsvr.vehicle.changes import LEVEL, Changes
from incsvr.vehicle.compare import Value
from incsvr.vehicle.history import SAME_SPEED, History
from service.commands.change_text import change_words, value_line
from service.host.persist_then_publish import DIVES_KEY
from service.learner.dives import DiveLine
from service.state.state_file import StateDamage, StateFile

Row = dict[str, Any]


def read(paths: Sequence[Path]) -> tuple[list[Row], list[str]]:
    """A row a dive, as of a table of dives, and what is left out of which learner.

    Args:
        paths: state directories of `serve`, or the files in them; their learners may be running.

    Raises:
        BadInput: there is no state, it is damaged, or nothing was learned yet.
    """
    rows, left_out = list[Row](), list[str]()
    for path in paths:
        files = sorted(path.rglob("*.sqlite")) if path.is_dir() else [path]
        files = [file for file in files if ".refused-" not in file.name]
        if not files:
            raise BadInput(f"{path}: there is no state of a learner; name the state directory of `serve`")
        for file in files:
            learner, lines = _lines(file)
            alike = [line for line in lines if _comparable(line, lines[-1])]
            rows += [_row(learner, line) for line in alike]
            if len(alike) < len(lines):
                left_out.append(
                    f"{file.stem}: {len(lines) - len(alike)} dives are left out, whose drag is of another speed or "
                    "freed of other effects than that of the newest"
                )
    if not rows:
        raise BadInput(f"{paths[0]}: no dive was learned yet; compare after two dives")
    return rows, left_out


def history(rows: Sequence[Row]) -> History:
    """The rows as `History` takes them."""
    texts = [[row[name] for row in rows] for name in ("vehicle", "axis", "quantity")]
    names = [list(dict.fromkeys(column)) for column in texts]
    codes = [np.array([n.index(text) for text in column]) for n, column in zip(names, texts, strict=True)]
    numbers = [
        np.array([row[name] for row in rows], dtype=np.float64)
        for name in ("at_speed", "estimate", "standard_error", "degrees_of_freedom")
    ]
    return History(codes[0], codes[1], codes[2], (names[0], names[1], names[2]), *numbers)


def values(rows: Sequence[Row], found: Changes) -> list[Value]:
    """The value of each row, with what the test says of it."""
    columns = (found.reference, found.reference_error, found.p_value)
    tested = zip(*([None if np.isnan(each) else float(each) for each in column] for column in columns), strict=True)
    return [
        Value(
            estimate=row["estimate"],
            error=row["standard_error"],
            freedom=row["degrees_of_freedom"],
            low=row["low"],
            high=row["high"],
            reference=mean,
            reference_error=error,
            p_value=p_value,
            changed=changed,
        )
        for row, (mean, error, p_value), changed in zip(rows, tested, found.changed.tolist(), strict=True)
    ]


def text(rows: Sequence[Row], found: Sequence[Value], left_out: Sequence[str]) -> str:
    """The comparison for people: a table a quantity, and the changes."""
    tables: dict[tuple[str, str, str], list[tuple[Row, Value]]] = {}
    for row, value in zip(rows, found, strict=True):
        tables.setdefault((row["vehicle"], row["axis"], row["quantity"]), []).append((row, value))
    lines, changes = list[str](), list[str]()
    for (vehicle, axis, quantity), own in tables.items():
        what = f"{vehicle} {axis} {quantity.replace('_', ' ')}"
        speed = "m/s" if AXES[axis].along else "rad/s"
        lines.append(f"{what} at {own[0][0]['at_speed']:.3g} {speed} [{own[0][0]['unit']}]")
        for row, value in own:
            lines.append(value_line(row["dive"], value))
            if value.changed:
                changes.append(f"{row['dive']}: {what} {change_words(value)}")
    closing = changes or ["no change proven"]
    certainty = f"The chance of any false change of one vehicle is at most {100.0 * LEVEL:.0f} %."
    return "\n".join([*lines, "", *closing, *left_out, certainty])


def _lines(file: Path) -> tuple[str, list[DiveLine]]:
    """The vehicle and the axis of a learner, such as "leng/yaw", and the lines of its dives."""
    try:
        state = StateFile(file)
        try:
            identity, memory = state.identity(), state.memory() or {}
        finally:
            state.close()
        return str(identity["vehicle"]), [DiveLine(**each) for each in memory.get(DIVES_KEY, ())]
    except (StateDamage, sqlite3.Error, OSError, KeyError, TypeError) as error:
        raise BadInput(f"{file}: this state cannot be read ({error}); name another") from None


def _comparable(line: DiveLine, newest: DiveLine) -> bool:
    """Whether drags are of one speed, and freed of the same effects."""
    return line.effects == newest.effects and abs(line.at_speed - newest.at_speed) <= SAME_SPEED * newest.at_speed


def _row(vehicle: str, line: DiveLine) -> Row:
    """A line in the form of a table of dives."""
    reach = float(student.ppf(0.975, line.degrees_of_freedom)) * line.standard_error
    began = datetime.fromtimestamp(line.began, UTC)
    return {
        "vehicle": vehicle, "version": version("incsvr"), "dive": f"{began:%Y-%m-%d %H:%M:%S}", "axis": line.axis,
        "quantity": line.quantity, "at_speed": line.at_speed, "unit": "N" if AXES[line.axis].along else "N m",
        "estimate": line.estimate, "standard_error": line.standard_error,
        "degrees_of_freedom": float(line.degrees_of_freedom), "low": line.estimate - reach,
        "high": line.estimate + reach, "seconds": line.seconds, "rms_speed": line.rms_speed,
    }  # fmt: skip
