"""Parquet files: one table, read by pyarrow."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array
from service.cli.extras import load_package
from service.inputs.table import Table
from service.logs.cells import columns_of
from service.logs.log import Log, table_log


def open_log(path: Path) -> Log:
    """Reads the whole file; instants become seconds since 1970, durations seconds.

    Raises:
        BadInput: it is damaged, or pyarrow is missing.
    """
    parquet, arrow = load_package("pyarrow.parquet", path, "Parquet"), load_package("pyarrow", path, "Parquet")
    try:
        table = parquet.read_table(path)
        while any(arrow.types.is_struct(field.type) for field in table.schema):
            table = table.flatten()
    except (arrow.ArrowException, OSError) as error:
        raise BadInput(f"{path}: cannot be read as Parquet ({str(error).splitlines()[0]}); write it again") from None
    columns: dict[str, Array] = {}
    texts: dict[str, tuple[str, ...]] = {}
    instants: list[str] = []
    for field in table.schema:
        column, kind = table.column(field.name), arrow.types
        if kind.is_timestamp(field.type) or kind.is_duration(field.type):
            whole = arrow.timestamp("ns") if kind.is_timestamp(field.type) else arrow.duration("ns")
            column = column.cast(whole).cast(arrow.int64())
            columns[field.name] = _numbers(column.cast(arrow.float64(), safe=False)) * 1e-9
            instants += [field.name] * kind.is_timestamp(field.type)
        elif kind.is_floating(field.type) or kind.is_integer(field.type) or kind.is_decimal(field.type):
            columns[field.name] = _numbers(column.cast(arrow.float64(), safe=False))
        elif kind.is_boolean(field.type):
            columns[field.name] = _numbers(column.cast(arrow.int8()).cast(arrow.float64()))
        elif kind.is_string(field.type) or kind.is_large_string(field.type):
            texts[field.name] = tuple(cell or "" for cell in column.to_pylist())
    found = columns_of(list(texts), list(zip(*texts.values(), strict=True)))
    table = Table(None, columns | found.numbers, found.texts, (*instants, *found.instants))
    return table_log("Parquet", table, found.notes)


def _numbers(column: object) -> Array:
    """NaN where a cell is empty."""
    return np.asarray(column.to_numpy(), dtype=np.float64)  # type: ignore[attr-defined]
