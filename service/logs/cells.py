"""The cells of a table of text as numbers: decimal commas, thousands, dates, times of day, a row of units."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from math import nan

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array
from service.inputs.columns import names_unit
from service.inputs.units import FACTORS, STAMP_UNITS, unit
from service.number import number_of

EMPTY_CELLS = {"", "nan", "na", "n/a", "null", "none", "-", "#n/a", "#value!", "#div/0!", "#num!", "#ref!", "#null!"}
"""The cells in whose place nothing was sampled, or a spreadsheet could not compute it."""
DAY_S, HOUR_S = 86_400.0, 3600.0
_CLOCK = re.compile(
    r"^(?:(\d+) days? )?(?:(\d+):)?(\d{1,2}):(\d{1,2}(?:[.,]\d+)?)\s*([ap])?\.?(?:m\.?)?$", re.IGNORECASE
)
_DATE = re.compile(r"^(\d{1,4})([./-])(\d{1,2})\2(\d{1,4})[ T,]+(.*)$")
_MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
_NAMED_MONTH = re.compile(rf"^(\d{{1,4}})[ ./-]({'|'.join(_MONTHS)})[a-z]*[ ./-](?=\d)", re.IGNORECASE)
_GROUPS = {"'": "'’ \u00a0\u202f", ".": ".", ",": ","}
"""Marks between thousands: those that only group, and the two that may be a decimal mark instead."""


class CellFault(BadInput):
    """The refusal of a table whose cells are spelt in a way that is recognised, and cannot be read."""


@dataclass(frozen=True, slots=True)
class Columns:
    """The columns of a table of text.

    Attributes:
        numbers: by name.
        texts: those that are none, by name.
        instants: the names of those that were dates or times of day.
        notes: how cells were read that are no plain numbers, one sentence each.
        in_si: the names of those whose unit stood among their cells: it is used already.
    """

    numbers: dict[str, Array]
    texts: dict[str, tuple[str, ...]]
    instants: tuple[str, ...]
    notes: tuple[str, ...]
    in_si: tuple[str, ...] = ()


def columns_of(header: Sequence[str], rows: Sequence[Sequence[str]], ours: bool = False) -> Columns:
    """The columns under a header; a first row that holds units is used, and is no row of the table.

    Args:
        ours: whether a point is known to be the decimal mark, as in recordings of our own.
    """
    cells = {name: [row[k].strip() if k < len(row) else "" for row in rows] for k, name in enumerate(header) if name}
    units = {name: each[0].strip("[]()") for name, each in cells.items()}
    with_units = len(rows) > 2 and _is_units_row(list(units.values()), [each[1] for each in cells.values()])
    numbers, texts, instants, notes = dict[str, Array](), dict[str, tuple[str, ...]](), list[str](), list[str]()
    in_si = list[str]()
    for name, column in cells.items():
        below = column[1:] if with_units else column
        spelt = units[name] if with_units else ""
        values, how = _read(below, ours)
        if values is None and (behind := _unit_behind(below)):
            spelt, (values, how) = behind, _read([cell.removesuffix(behind).rstrip() for cell in below], ours)
            notes.append(f"the unit behind each number of {name} is read: {behind}")
        if values is None:
            texts[name] = tuple(below)
            continue
        numbers[name] = values
        if how == _INSTANTS:
            instants.append(name)
        elif how:
            notes.append(how)
        if spelt and how != _INSTANTS and not names_unit(name):
            factor = FACTORS.get(unit(spelt) or "", STAMP_UNITS.get(unit(spelt) or "", 1.0))
            numbers[name] = values * factor if factor != 1.0 else values
            in_si += [name] if unit(spelt) else []
    if with_units:
        said = [
            f"{name} in {each}{'' if unit(each) else ' (taken as SI)'}"
            for name, each in units.items()
            if each and not names_unit(name)
        ] or ["those of the header"]
        notes.append(f"row 2 holds no numbers, and is read as units: {', '.join(said)}")
    return Columns(numbers, texts, tuple(instants), tuple(dict.fromkeys(notes)), tuple(in_si))


def _unit_behind(cells: Sequence[str]) -> str | None:
    """The known unit that stands behind the number in each cell that has one; None where they have none, or several."""
    spelt = {cell.lstrip("+-0123456789.,eE \u00a0") for cell in cells if cell.lower() not in EMPTY_CELLS}
    return spelt.pop() if len(spelt) == 1 and unit(min(spelt)) else None


def first_unread(cells: Sequence[str]) -> int:
    """The place of the first cell of a column of texts that is no number, date or time of day where others are."""
    return next((k for k, cell in enumerate(cells) if _read([cell])[0] is None and cell.lower() not in EMPTY_CELLS), 0)


def refuse_split_decimals(path: object, header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Refuses rows that decimal commas without quotes split into more cells than the header has.

    Raises:
        CellFault: they do.
    """
    for number, row in enumerate(rows, start=2):
        if len(row) > len(header) and any(row[len(header) :]):
            pointed = any(re.fullmatch(r"\s*[+-]?\d*\.\d*(e[+-]?\d+)?\s*", cell, re.IGNORECASE) for cell in row)
            whole = sum(re.fullmatch(r"\s*[+-]?\d+\s*", cell) is not None for cell in row)
            if len(row) <= 2 * len(header) and not pointed and whole >= 2:
                raise CellFault(
                    f"{path}, row {number}: {len(row)} cells, of which none has a decimal point, under a header of "
                    f"{len(header)} look like decimal commas between cells that commas separate; export with points, "
                    "or with semicolons between cells"
                )
            return


_INSTANTS = "instants"


def _is_units_row(first: Sequence[str], second: Sequence[str]) -> bool:
    """Whether a row holds no number, but some text, above a row of which most are numbers."""
    if not any(first) or any(cell.lower() not in EMPTY_CELLS and _read([cell])[0] is not None for cell in first):
        return False
    numeric = sum(_read([cell])[0] is not None for cell in second)
    return 2 * numeric > len(second)


def _read(cells: Sequence[str], ours: bool = False) -> tuple[Array | None, str]:
    """A column as numbers, and how it was read; None where it holds other texts."""
    plain = _plain_numbers(cells)
    if plain is not None:
        mark = None if ours else _grouped_by(cells, ".")
        return (plain, "") if mark is None else (_ungrouped(cells, mark), _thousands(mark))
    for mark in _GROUPS:
        if _grouped_by(cells, mark) is not None:
            return _ungrouped(cells, mark), _thousands(mark)
    commas = [plain_number(cell.replace(",", ".")) if cell.count(",") <= 1 else None for cell in cells]
    if None not in commas:
        return np.array(commas), "decimal commas are read as points"
    instants = _dates(cells)
    return (instants, _INSTANTS) if instants is not None else (None, "")


def _thousands(mark: str) -> str:
    return f"the marks {'between' if mark == chr(39) else repr(mark) + ' between'} thousands are left out"


def _plain_numbers(cells: Sequence[str]) -> Array | None:
    """A column of numbers that need no mark looked at, NaN where nothing was sampled; None where there is another."""
    try:
        number = number_of if "_" in "".join(cells) else float  # of a million cells, each call counts
        return np.array([number(cell) if cell else nan for cell in cells])
    except ValueError:
        values = [plain_number(cell) for cell in cells]
        return None if None in values else np.array(values, dtype=np.float64)


def plain_number(cell: str) -> float | None:
    """The number in a cell, NaN where nothing was sampled; None where it is none, or has another decimal mark."""
    try:
        return number_of(cell)
    except ValueError:
        pass
    if cell.lower() in EMPTY_CELLS:
        return nan
    return float(cell.lower() == "true") if cell.lower() in {"true", "false"} else None


def _grouped_by(cells: Sequence[str], mark: str) -> str | None:
    """The mark, if it separates thousands in a column: in some cell without doubt, or beside smaller whole numbers."""
    group = f"[{_GROUPS[mark]}]"
    decimal = {"'": "[.,]", ".": ",", ",": "\\."}[mark]
    whole = re.compile(rf"^[+-]?\d{{1,3}}((?:{group}\d{{3}})*)({decimal}\d+)?$")
    found = list[re.Match[str]]()
    for cell in cells:
        match = whole.match(cell)
        if match is not None:
            found.append(match)
        elif cell.lower() not in EMPTY_CELLS:
            return None
    if not found:
        return None
    groups = [len(each[1]) // 4 for each in found]
    if not any(groups):
        return None
    if mark == "'" or max(groups) > 1 or any(each[1] and each[2] for each in found):
        return mark
    texts = [each[0].lstrip("+-") for each in found]
    larger = [text for text, count in zip(texts, groups, strict=True) if count]
    smaller = [text for text, count in zip(texts, groups, strict=True) if not count]
    certain = any(len(text) == 3 for text in smaller) and any(text.endswith("0") for text in larger)
    return mark if certain and not any(text.startswith("0") for text in larger) else None


def _ungrouped(cells: Sequence[str], mark: str) -> Array:
    marks = re.compile(f"[{_GROUPS[mark]}]")
    return np.array(
        [nan if (c := cell.lower()) in EMPTY_CELLS else float(marks.sub("", c).replace(",", ".")) for cell in cells]
    )


def _dates(cells: Sequence[str]) -> Array | None:
    """Dates as seconds since 1970, UTC where they name no zone, or times of day that go on past midnight."""
    found = [
        values for read in (_instant, _of_day, _day_first, _month_first) if (values := _by(read, cells)) is not None
    ]
    if not found:
        return None
    if len(found) > 1:  # days and months that may be either: a log is short
        return min(found, key=lambda values: float(np.nanmax(values) - np.nanmin(values)))
    return _past_midnight(found[0], cells) if all(":" in cell[:3] for cell in cells if cell) else found[0]


def _by(read: Callable[[str], float | None], cells: Sequence[str]) -> Array | None:
    """A column as a reader of one cell reads it; None where it cannot read one, or nothing is there."""
    values, some = np.empty(len(cells)), False
    for row, cell in enumerate(cells):
        value = nan if cell.lower() in EMPTY_CELLS else read(cell)
        if value is None:
            return None
        values[row] = value
        some |= value == value
    return values if some else None


def _instant(cell: str) -> float | None:
    try:
        instant = datetime.fromisoformat(cell.removesuffix(" UTC"))
    except ValueError:
        return None
    return (instant if instant.tzinfo else instant.replace(tzinfo=UTC)).timestamp()


def _of_day(cell: str) -> float | None:
    """Seconds of a time of day, or of minutes and seconds."""
    found = _CLOCK.match(cell)
    if found is None:
        return None
    hour, half = float(found[2] or 0), (found[5] or "").lower()
    hour = hour if not half else hour % 12.0 + 12.0 * (half == "p")
    return DAY_S * float(found[1] or 0) + HOUR_S * hour + 60.0 * float(found[3]) + float(found[4].replace(",", "."))


def _past_midnight(values: Array, cells: Sequence[str]) -> Array:
    """Times of day that count on past midnight, or past the hour where they have no hours."""
    period = DAY_S if any(cell.count(":") == 2 for cell in cells) else HOUR_S
    known = np.isfinite(values)
    steps = np.diff(values[known], prepend=values[known][:1])
    values[known] += period * np.cumsum(steps < -0.5 * period)
    return values


def _day_first(cell: str, month_first: bool = False) -> float | None:
    """Seconds since 1970 of a date with points, strokes, slashes or a month's English name, and a time of day."""
    if not month_first:
        cell = _NAMED_MONTH.sub(lambda of: f"{of[1]}-{_MONTHS.index(of[2].lower()) + 1}-", cell)
    found = _DATE.match(cell)
    of_day = None if found is None else _of_day(found[5])
    if found is None or of_day is None:
        return None
    day, month, year = int(found[1]), int(found[3]), int(found[4])
    if len(found[1]) == 4:
        year, day = day, year
    elif month_first:
        day, month = month, day
    try:
        return datetime(year + 2000 * (year < 100), month, day, tzinfo=UTC).timestamp() + of_day
    except ValueError:
        return None


def _month_first(cell: str) -> float | None:
    return _day_first(cell, month_first=True)
