"""Tables of text with any delimiter, plain or gzipped, with stamps as numbers or as ISO 8601."""

from __future__ import annotations

import csv
import gzip
import io
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from math import nan
from pathlib import Path

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array
from service.inputs.table import ROWS, Table, Topic
from service.logs.opening import GZIP, first_bytes
from service.number import number_of

_DELIMITERS = ",;\t|"
EMPTY_CELLS = {"", "nan", "na", "n/a", "null", "none", "-"}
"""The cells in whose place nothing was sampled."""


@dataclass(frozen=True, slots=True)
class TableLog:
    """A file that is one table: a topic whose fields are its columns.

    Nothing says when its rows were written down, but a column that is the time.
    """

    format: str
    table: Table

    @property
    def notes(self) -> tuple[str, ...]:
        """No notes: a table has no messages that could not be read."""
        return ()

    @property
    def topics(self) -> tuple[Topic, ...]:
        return (Topic(ROWS, "", tuple(self.table.columns), self.table.count),)

    def read(self, names: Collection[str]) -> Mapping[str, Table]:
        return {ROWS: self.table} if ROWS in names else {}


def open_log(path: Path) -> TableLog:
    """Reads the whole file.

    Raises:
        BadInput: it is no table of text.
    """
    text = _text(path)
    lines = text.lstrip("\ufeff").splitlines()
    while lines and not lines[0].strip():
        lines.pop(0)
    if not lines:
        raise BadInput(f"{path}: the file is empty; a log begins with a header that names its columns")
    delimiter = max(_DELIMITERS, key=lines[0].count)
    rows = _rows(path, lines, delimiter)
    header = [name.strip() for name in rows[0]]
    if any(header) and all(_parsed(name, ".") is not None for name in header):
        raise BadInput(f"{path}, row 1: the header is missing, the first row holds numbers; name the columns there")
    if len(rows) < 2:
        raise BadInput(f"{path}: there are no rows below the header; record at least a few seconds")
    point = "," if delimiter == ";" else "."
    columns: dict[str, Array] = {}
    texts: dict[str, tuple[str, ...]] = {}
    for position, name in enumerate(header):
        if not name or name in columns or name in texts:
            raise BadInput(f"{path}, row 1: column {position + 1} is named {name!r}; give every column its own name")
        cells = [row[position].strip() if position < len(row) else "" for row in rows[1:]]
        numbers = _numbers(cells, point)
        if numbers is None:
            texts[name] = tuple(cells)
        else:
            columns[name] = numbers
    return TableLog("CSV", Table(None, columns, texts))


def _text(path: Path) -> str:
    try:
        content = path.read_bytes()
        if first_bytes(path).startswith(GZIP):
            content = gzip.decompress(content)
        return content.decode("utf-8")
    except OSError as error:
        raise BadInput(f"{path}: cannot be read ({error.strerror or error}); give the path of a recording") from None
    except (UnicodeDecodeError, EOFError):
        raise BadInput(f"{path}: this is no CSV text; export the recording as UTF-8 CSV") from None


def _rows(path: Path, lines: Sequence[str], delimiter: str) -> list[list[str]]:
    if delimiter not in lines[0]:
        return [line.split() for line in lines if line.strip()]
    try:
        rows = csv.reader(io.StringIO("\n".join(lines)), delimiter=delimiter)
        return [row for row in rows if any(row)]
    except csv.Error as error:
        raise BadInput(f"{path}: this is no CSV text ({error}); export the recording as UTF-8 CSV") from None


def _numbers(cells: Sequence[str], point: str) -> Array | None:
    """A column as numbers: floats, or instants in seconds since 1970; None where it holds other texts."""
    values = np.empty(len(cells))
    for row, cell in enumerate(cells):
        value = _parsed(cell, point)
        if value is None:
            return _instants(cells)
        values[row] = value
    return values


def _parsed(cell: str, point: str) -> float | None:
    try:
        return number_of(cell)
    except ValueError:
        pass
    if cell.lower() in EMPTY_CELLS:
        return nan
    if cell.lower() in {"true", "false"}:
        return float(cell.lower() == "true")
    if point == ",":
        try:
            return number_of(cell.replace(",", "."))
        except ValueError:
            return None
    return None


def _instants(cells: Sequence[str]) -> Array | None:
    """ISO 8601 stamps as seconds since 1970, UTC where they name no zone; None where one of them is none."""
    values = np.empty(len(cells))
    for row, cell in enumerate(cells):
        if cell.lower() in EMPTY_CELLS:
            values[row] = nan
            continue
        try:
            instant = datetime.fromisoformat(cell)
        except ValueError:
            return None
        values[row] = (instant if instant.tzinfo else instant.replace(tzinfo=UTC)).timestamp()
    return values
