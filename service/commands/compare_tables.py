"""Stored coefficients of dives, of one vehicle or of a fleet: written, read, and compared."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.vehicle.changes import LEVEL, Changes
from incsvr.vehicle.compare import Comparison, Value
from incsvr.vehicle.history import History
from incsvr.vehicle.shown import Shown
from service.cli.extras import how_to_install
from service.cli.next_command import following, with_next
from service.cli.output import emit
from service.fitting.compare import change_words
from service.recordings.log_refusals import DIVE_GIVEN_TWICE

MAX_LINES = 40
"""Changes of a fleet that are printed; all stand in the table and in the JSON."""


def run_on_tables(args: argparse.Namespace) -> int:
    """Compares stored coefficients."""
    for path in args.dives:
        if not is_dive_table(path):
            raise BadInput(f"{path}: is no table of dives; compare either logs or tables of dives")
    if args.report:
        raise BadInput("--report needs the logs of one vehicle's dives; of tables, --table writes what was found")
    table, history = read_dives(args.dives, whole=args.table is not None)
    found = history.changes()
    if args.table is not None:
        write_compared(args.table, table, found)
    rows, seen = _changed_rows(table, history, found), history.shown(found, table.column("dive"))
    if args.table is None:
        after = following(args, "compare", args.dives, (), "--table", "compared.parquet"), "keeps the test of each row"
    else:
        after = following(args, "compare", [args.table], (), "--json", "changes.json"), "lists the changes for programs"
    shown = [each.to_dict() for each in seen]
    document = {"coefficients": table.num_rows, "changes": rows, "shown": shown, "next": after[0]}
    emit(args, document, with_next(_text_of_tables(rows, history, found, seen), *after))
    return 0


def _changed_rows(table: Any, history: History, found: Changes) -> list[dict[str, Any]]:
    """Each change that was found, of all vehicles."""
    vehicles, axes, quantities = history.names
    return [
        {
            "vehicle": vehicles[history.vehicle[k]], "dive": table.column("dive")[k].as_py(),
            "axis": axes[history.axis[k]], "quantity": quantities[history.quantity[k]],
            "estimate": float(history.estimate[k]), "reference": float(found.reference[k]),
            "p_value": float(found.p_value[k]),
        }
        for k in np.flatnonzero(found.changed).tolist()
    ]  # fmt: skip


def _text_of_tables(rows: list[dict[str, Any]], history: History, found: Changes, seen: Sequence[Shown]) -> str:
    """The changes of a fleet for people."""
    none = np.full(history.estimate.size, np.nan)
    tested = (found.reference, found.reference_error, found.p_value, found.changed)
    columns = (history.estimate, history.error, history.freedom, none, none, *tested)
    lines = []
    for row, k in zip(rows[:MAX_LINES], np.flatnonzero(found.changed).tolist(), strict=False):
        value = Value(*(column[k] for column in columns))
        lines.append(f"{row['vehicle']}, {row['dive']}: {row['axis']} {row['quantity']} {change_words(value)}")
    if len(rows) > MAX_LINES:
        lines.append(f"and {len(rows) - MAX_LINES} more: --table or --json holds all")
    lines += [each.sentence for each in seen[:MAX_LINES]]
    if len(seen) > MAX_LINES:
        lines.append(f"and what {len(seen) - MAX_LINES} more coefficients could have shown: --json holds all")
    lines.append("The dives are in the order of the rows.")
    number = len(history.names[0])
    lines.append(
        f"{len(rows)} changes in {history.estimate.size} coefficients of {number} vehicle{'s' * (number != 1)}. The "
        f"chance of any false change of one vehicle over all its dives is at most {100.0 * LEVEL:.0f} %."
    )
    return "\n".join(lines)


TEXTS = ("vehicle", "axis", "quantity")
NUMBERS = ("at_speed", "estimate", "standard_error", "degrees_of_freedom")
"""Columns that a table must have to be compared."""


def write_dives(path: Path, compared: Comparison, vehicle: str) -> None:
    """Writes the rows of a comparison of one vehicle."""
    arrow, parquet = packages()
    about = {"vehicle": vehicle, "version": version("incsvr")}
    table = arrow.Table.from_pylist([{**about, **row} for row in compared.rows()])
    parquet.write_table(table, path, store_schema=False)


def is_dive_table(path: Path) -> bool:
    """Whether a file is a table of dives, by its columns."""
    if path.suffix != ".parquet" or not path.is_file():
        return False
    arrow, parquet = packages()
    try:
        return {*TEXTS, *NUMBERS} <= set(parquet.read_schema(path).names)
    except (arrow.ArrowException, OSError):
        return False  # the reader of logs says what is wrong with it


def read_dives(paths: Sequence[Path], whole: bool) -> tuple[Any, History]:
    """The rows of tables, one after the other, as an Arrow table and as a history.

    Args:
        whole: whether every column is wanted; else only those that a comparison needs.

    Raises:
        BadInput: a table is damaged, or its columns are of another kind.
    """
    arrow, _ = packages()
    columns = [*TEXTS, "dive", *NUMBERS]
    try:
        parts = [_part(path, None if whole else columns) for path in paths]
        table = arrow.concat_tables(parts, promote_options="default").unify_dictionaries().combine_chunks()
        coded = [table.column(name).combine_chunks() for name in TEXTS]
        vehicle, axis, quantity = (column.indices.to_numpy(zero_copy_only=False).astype(np.int64) for column in coded)
        numbers = [table.column(name).to_numpy() for name in NUMBERS]
        names = (coded[0].dictionary.to_pylist(), coded[1].dictionary.to_pylist(), coded[2].dictionary.to_pylist())
        speed, estimate, error, freedom = (np.asarray(column, dtype=np.float64) for column in numbers)
    except (arrow.ArrowException, OSError, AttributeError, ValueError, KeyError) as error_:
        raise BadInput(
            f"{paths[0]}: no table of dives can be read ({str(error_).splitlines()[0]}); write it with "
            "`incsvr compare --table`"
        ) from None
    if table.num_rows == 0:
        raise BadInput(f"{paths[0]}: the table of dives has no rows; write it with `incsvr compare --table`")
    if len(paths) > 1 and table.group_by(columns).aggregate([]).num_rows < table.num_rows:
        raise BadInput(f"{' and '.join(path.name for path in paths)} hold the same dive, and {DIVE_GIVEN_TWICE}")
    return table, History(vehicle, axis, quantity, names, speed, estimate, error, freedom)


def _part(path: Path, columns: Sequence[str] | None) -> Any:
    """One table, its texts by their codes, which repeat."""
    arrow, parquet = packages()
    texts = [field.name for field in parquet.read_schema(path) if arrow.types.is_string(field.type)]
    return parquet.read_table(path, columns=columns, read_dictionary=texts)


def write_compared(path: Path, table: Any, found: Changes) -> None:
    """Writes rows that were read, with all their columns, and what the test says of each."""
    arrow, parquet = packages()
    judged = {
        "reference": found.reference, "p_value": found.p_value, "changed": found.changed,
        "smallest_change": found.smallest,
    }  # fmt: skip
    for name, values in judged.items():
        column, place = arrow.array(values, from_pandas=True), table.schema.get_field_index(name)
        table = table.append_column(name, column) if place < 0 else table.set_column(place, name, column)
    parquet.write_table(table, path, store_schema=False)


def packages() -> tuple[Any, Any]:
    """pyarrow and its part for Parquet.

    Raises:
        BadInput: they are not installed.
    """
    try:
        return import_module("pyarrow"), import_module("pyarrow.parquet")
    except ModuleNotFoundError:
        raise BadInput(f"a table needs pyarrow, which is not installed: {how_to_install('pyarrow')}") from None
