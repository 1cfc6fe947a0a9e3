"""Tables of text with any delimiter, plain or gzipped, with stamps as numbers, dates or times of day."""

from __future__ import annotations

import csv
import gzip
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import chain, islice
from pathlib import Path

from incsvr.errors import BadInput
from service.inputs.clocks import table_time
from service.inputs.table import ROWS, Table
from service.logs.cells import EMPTY_CELLS, columns_of, refuse_split_decimals
from service.logs.log import Log, table_log
from service.logs.opening import GZIP, UTF_16, first_bytes
from service.logs.own_table import refuse_faults
from service.number import number_of

OURS = "recording"
"""The format of a table that was read as a recording of our own, every fault of a row named."""
_DELIMITERS = ",;\t|"
REMARKS = ("#", "%", "//")
"""What a remark above a table begins with."""
_NO_TEXT = re.compile(rb"[\x00-\x08\x0b\x0c\x0e-\x1f]")
"""A byte that no text has."""
HEAD_LINES = 20
"""Lines by which a table is told."""


def open_log(path: Path, ours: bool = False) -> Log:
    """Reads the whole file.

    Args:
        ours: whether it begins as our recordings do, whose faults are named, but for other spellings of numbers and
            times.

    Raises:
        BadInput: it is no table of text, or has a fault.
    """
    every = csv_rows(path)
    rows = [row for row in every if any(row)]
    if not rows:
        raise BadInput(f"{path}: the file is empty; a log begins with a header that names its columns")
    again = [number for number, row in enumerate(every[1:], start=2) if row == rows[0]]
    rows, header = [rows[0], *(row for row in rows[1:] if row != rows[0])], [name.strip() for name in rows[0]]
    if any(header) and all(_is_number(name) for name in header):
        raise BadInput(f"{path}, row 1: the header is missing, the first row holds numbers; name the columns there")
    if len(rows) < 2:
        raise BadInput(f"{path}: there are no rows below the header; record at least a few seconds")
    refuse_unnamed(path, header)
    refuse_split_decimals(path, header, rows[1:])
    found = columns_of(header, rows[1:], ours)
    if again:
        note = f"the header comes again in row {again[0]}{' and others' * (len(again) > 1)}: it is left out there"
        found = replace(found, notes=(*found.notes, note))
    log = table_log("CSV", Table(None, found.numbers, found.texts, found.instants, found.in_si), found.notes)
    if not ours or found.notes or "t" in found.instants:
        return log
    try:
        refuse_faults(path, header, every, found)
    except BadInput:
        if "t" in found.numbers and table_time(log.tables[ROWS], "t")[1]:
            return log
        raise
    return replace(log, format=OURS)


def csv_rows(path: Path) -> list[list[str]]:
    """The rows of a table of text, plain or gzipped, of any usual encoding, the header first.

    Its header tells the delimiter; what stands above it is left out.

    Raises:
        BadInput: it cannot be read, or is no text.
    """
    opened = gzip.open if first_bytes(path).startswith(GZIP) else open
    try:
        with opened(path, "rb") as file:
            encoding = "utf-16" if file.read(2) in UTF_16 else "utf-8-sig"
        try:
            with opened(path, "rt", newline="", encoding=encoding) as file:
                return _rows(file)
        except UnicodeDecodeError:
            with opened(path, "rb") as file:
                if any(_NO_TEXT.search(line) for line in file):
                    raise
            with opened(path, "rt", newline="", encoding="cp1252") as file:
                return _rows(file)
    except OSError as error:
        raise BadInput(f"{path}: cannot be read ({error.strerror or error}); give the path of a recording") from None
    except (UnicodeDecodeError, EOFError):
        raise BadInput(f"{path}: this is no CSV text; export the recording as UTF-8 CSV") from None
    except csv.Error as error:
        raise BadInput(f"{path}: this is no CSV text ({error}); export the recording as UTF-8 CSV") from None


def _rows(lines: Iterable[str]) -> list[list[str]]:
    lines = _from_header(lines)
    first = next(lines, "")
    delimiter, lines = max(_DELIMITERS, key=first.count), chain([first], lines)
    if delimiter not in first:
        return [line.split() for line in lines if line.strip()]
    return list(csv.reader(lines, delimiter=delimiter))


def _from_header(lines: Iterable[str]) -> Iterator[str]:
    """The lines from the header on, without what people and spreadsheets write above it.

    Above it are empty lines, `sep=;`, remarks, and titles without a delimiter. Where numbers follow the last remark,
    that one is the header.
    """
    lines = iter(lines)
    head, remark = list(islice(lines, HEAD_LINES)), ""
    is_table = 2 * sum(any(mark in line for mark in _DELIMITERS) for line in head) > len(head)
    lines = chain(head, lines)
    for line in lines:
        if line.startswith(REMARKS) and any(mark in line.strip() for mark in (*_DELIMITERS, " ")):
            remark = line
            continue
        is_title = is_table and not any(mark in line for mark in _DELIMITERS)
        if line.strip() and not is_title and not line.lower().startswith("sep="):
            cells = re.split(f"[{_DELIMITERS}]|\\s+", line.strip())
            is_header = not remark or not all(map(_is_number, cells))
            return chain([line] if is_header else [remark.lstrip("".join(REMARKS)), line], lines)
        remark = ""
    return iter(())


def refuse_unnamed(path: Path, header: Sequence[str]) -> None:
    """Raises BadInput where a column has no name, or that of another one."""
    for position, name in enumerate(header):
        if not name or name in header[:position]:
            raise BadInput(f"{path}, row 1: column {position + 1} is named {name!r}; give every column its own name")


def _is_number(cell: str) -> bool:
    try:
        number_of(cell)
    except ValueError:
        return cell.lower() in EMPTY_CELLS
    return True
