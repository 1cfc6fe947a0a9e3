"""Tables of text with any delimiter, plain or gzipped, with stamps as numbers, dates or times of day."""

from __future__ import annotations

import csv
import gzip
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from incsvr.errors import BadInput
from service.inputs.table import ROWS, Table, Topic
from service.logs.cells import EMPTY_CELLS, columns_of, refuse_split_decimals
from service.logs.opening import GZIP, UTF_16, first_bytes
from service.number import number_of

_DELIMITERS = ",;\t|"
REMARKS = ("#", "%", "//")
"""What a remark above a table begins with."""
SPACE = 0x20
"""The first character that is written."""
HEAD_LINES = 20
"""Lines by which a table is told."""


@dataclass(frozen=True, slots=True)
class TableLog:
    """A file that is one table: a topic whose fields are its columns.

    Nothing says when its rows were written down, but a column that is the time.
    """

    format: str
    table: Table
    notes: tuple[str, ...] = ()

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
    lines = _from_header(text.lstrip("\ufeff").splitlines())
    if not lines:
        raise BadInput(f"{path}: the file is empty; a log begins with a header that names its columns")
    delimiter = max(_DELIMITERS, key=lines[0].count)
    rows = _rows(path, lines, delimiter)
    header = [name.strip() for name in rows[0]]
    if any(header) and all(_is_number(name) for name in header):
        raise BadInput(f"{path}, row 1: the header is missing, the first row holds numbers; name the columns there")
    if len(rows) < 2:
        raise BadInput(f"{path}: there are no rows below the header; record at least a few seconds")
    for position, name in enumerate(header):
        if not name or name in header[:position]:
            raise BadInput(f"{path}, row 1: column {position + 1} is named {name!r}; give every column its own name")
    refuse_split_decimals(path, header, rows[1:])
    found = columns_of(header, rows[1:])
    return TableLog("CSV", Table(None, found.numbers, found.texts, found.instants), found.notes)


def _from_header(lines: list[str]) -> list[str]:
    """The lines from the header on, without what people and spreadsheets write above it.

    Above it are empty lines, `sep=;`, remarks, and titles without a delimiter. Where numbers follow the last remark,
    that one is the header.
    """
    first, remark = 0, -1
    separated = sum(any(mark in line for mark in _DELIMITERS) for line in lines[:HEAD_LINES])
    is_table = 2 * separated > min(len(lines), HEAD_LINES)
    for first, line in enumerate(lines):
        if line.startswith(REMARKS) and any(mark in line for mark in (*_DELIMITERS, " ")):
            remark = first
            continue
        is_title = is_table and not any(mark in line for mark in _DELIMITERS)
        if line.strip() and not is_title and not line.lower().startswith("sep="):
            break
    else:
        return []
    cells = re.split(f"[{_DELIMITERS}]|\\s+", lines[first].strip())
    if remark == first - 1 and remark >= 0 and all(map(_is_number, cells)):
        return [lines[remark].lstrip("".join(REMARKS)), *lines[first:]]
    return lines[first:]


def _text(path: Path) -> str:
    try:
        content = path.read_bytes()
        if first_bytes(path).startswith(GZIP):
            content = gzip.decompress(content)
        return _decoded(content)
    except OSError as error:
        raise BadInput(f"{path}: cannot be read ({error.strerror or error}); give the path of a recording") from None
    except (UnicodeDecodeError, EOFError):
        raise BadInput(f"{path}: this is no CSV text; export the recording as UTF-8 CSV") from None


def _decoded(content: bytes) -> str:
    """The text of a table, of whichever program."""
    if content.startswith(UTF_16):
        return content.decode("utf-16")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        if any(byte < SPACE and chr(byte) not in "\t\r\n" for byte in content):
            raise  # no text at all
        return content.decode("cp1252")


def _rows(path: Path, lines: Sequence[str], delimiter: str) -> list[list[str]]:
    if delimiter not in lines[0]:
        return [line.split() for line in lines if line.strip()]
    try:
        rows = csv.reader((f"{line}\n" for line in lines), delimiter=delimiter)
        return [row for row in rows if any(row)]
    except csv.Error as error:
        raise BadInput(f"{path}: this is no CSV text ({error}); export the recording as UTF-8 CSV") from None


def _is_number(cell: str) -> bool:
    try:
        number_of(cell)
    except ValueError:
        return cell.lower() in EMPTY_CELLS
    return True
