"""`incsvr compare`: compares dives of one vehicle, or the stored coefficients of many, and tells what changed when."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import replace
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning.coefficients import NORMAL_95_DEVIATIONS
from incsvr.vehicle import compare
from incsvr.vehicle.causes import causes
from incsvr.vehicle.changes import LEVEL, Changes
from incsvr.vehicle.compare import Comparison, Value
from incsvr.vehicle.history import History
from incsvr.vehicle.shown import Shown
from service.cli.extras import how_to_install
from service.cli.next_command import LOG_FLAGS, following, next_line
from service.cli.output import add_json_argument, emit, refuse_unwritable
from service.commands import log_configuration
from service.commands.arguments import REPORT_WRITER, add_report_argument, provenance
from service.commands.each_log import body_axes, refuse_frame, refuse_idle, refuse_odd
from service.commands.good_enough import MAX_CHANGE_SHARE, Use, good_enough, good_enough_lines, noticing, unknown
from service.commands.identify import TAKES, configured
from service.logs.cutting import MIN_STAMP_SINCE_1970_S
from service.recordings.log_refusals import (
    DIVE_GIVEN_TWICE,
    beside_assumptions,
    notes_of,
    refuse_implausible,
    refuse_twice,
)
from service.recordings.reading import Reading, add_log_arguments, read_body
from service.recordings.recording import Recording

MAX_LINES = 40
"""Changes of a fleet that are printed; all stand in the table and in the JSON."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "dives",
        nargs="+",
        type=Path,
        metavar="DIVE",
        help="logs of any format, compared in the order of their dates if all have one, else as given; or tables of "
        "dives, of one vehicle or of a fleet",
    )
    parser.add_argument("--name", default="vehicle", metavar="NAME", help="what the vehicle is called (vehicle)")
    log_configuration.add_arguments(parser, TAKES)
    parser.add_argument(
        "--table", type=Path, metavar="FILE.parquet", help="file for one row a dive and quantity (Parquet)"
    )
    add_report_argument(parser)
    add_log_arguments(parser, config=True, axis=False)
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    if any(is_dive_table(path) for path in args.dives):
        if args.table is not None:
            refuse_unwritable(args.table, "--table")
        return _run_on_tables(args)
    compared = answer(args)
    if args.report:
        made_of = provenance(argparse.Namespace(recordings=args.dives, validate=[]))
        import_module(REPORT_WRITER).write_dives(compared, explanations(compared), args.report, made_of)
    emit(args, to_dict(args, compared), text(args, compared))
    return 0


def to_dict(args: argparse.Namespace, compared: Comparison) -> dict[str, Any]:
    """The comparison for programs: the JSON of `--json`."""
    return {
        "rows": compared.rows(),
        "order": compared.order,
        "shown": [each.to_dict() for each in compared.shown],
        "vehicle": compared.identified.vehicle.to_dict(),
        "explanations": explanations(compared),
        "good_enough": good_enough([_noticed(compared)]),
        "next": _next(args, compared)[0],
    }


def _noticed(compared: Comparison) -> Use:
    """The verdict on the drag whose smallest change shows."""
    shares = {each.what: each.change / abs(each.reference) for each in compared.shown if each.change and each.reference}
    drags = {name: share for name, share in shares.items() if " drag" in name}
    if not drags:
        return unknown(
            "noticing a change", MAX_CHANGE_SHARE, "these dives determine no drag; record steps of each effort"
        )
    best = min(drags, key=lambda name: drags[name])
    return noticing(drags[best], best)


def _next(args: argparse.Namespace, compared: Comparison) -> tuple[str, str]:
    """The command that follows, and what it does."""
    last = max((compared.dives.index(dive) for dive, _, _ in compared.changes), default=0)
    named = {path.name: path for path in args.dives}
    logs = [named[dive] for dive in compared.dives[last:] if dive in named]
    why = "identifies the vehicle as it is since the last change" if last else "identifies the vehicle from all dives"
    flags = (*LOG_FLAGS, "set")
    return following(args, "identify", logs or args.dives, flags, "--write", "vehicle.yaml"), why


def answer(args: argparse.Namespace) -> Comparison:
    """The comparison of logs, written to `--table`.

    Raises:
        BadInput: a log cannot be used, or is a table of dives.
    """
    if args.table is not None:
        refuse_unwritable(args.table, "--table")
    for path in args.dives:
        if is_dive_table(path):
            raise BadInput(f"{path}: is a table of dives, which only the command incsvr compare takes; give logs")
    config, masses = configured(args)
    reading = Reading.of(args, config)
    recordings = [read_body(reading, [path])[0] for path in args.dives]
    refuse_twice(recordings, DIVE_GIVEN_TWICE)
    for recording in recordings:
        refuse_implausible(recording, reading.several)
    recordings, order = _in_order(recordings)
    with beside_assumptions(notes_of(recordings)):
        refuse_idle(recordings, body_axes(recordings))
        refuse_odd(recordings, body_axes(recordings))
        refuse_frame(recordings)
    streams = [recording.body_streams() for recording in recordings]
    compared = compare(streams, [recording.name for recording in recordings], masses)
    compared = replace(compared, order=order)
    if args.table is not None:
        write_dives(args.table, compared, args.name)
    return compared


def _in_order(recordings: list[Recording]) -> tuple[list[Recording], str]:
    """The dives in the order of their stamps, where all stamps are dates, else as given; and that order in words."""
    undated = next((each.name for each in recordings if each.time[0] < MIN_STAMP_SINCE_1970_S), None)
    if undated is not None:
        return recordings, f"in the order in which they were given, because {undated} has no date"
    ordered = sorted(recordings, key=lambda each: float(each.time[0]))
    given = (
        ""
        if all(a is b for a, b in zip(ordered, recordings, strict=True))
        else ", which is not the order in which they were given"
    )
    return ordered, f"in the order of their stamps{given}"


def _run_on_tables(args: argparse.Namespace) -> int:
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
    emit(args, document, f"{_text_of_tables(rows, history, found, seen)}\n\n{next_line(*after)}")
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


def explanations(compared: Comparison) -> dict[str, list[str]]:
    """Dive → the single causes that fit what changed in it, the likeliest first; empty where none does."""
    changed = dict.fromkeys(dive for dive, _, _ in compared.changes)
    return {dive: [cause.what for cause in causes(compared, compared.dives.index(dive))] for dive in changed}


def text(args: argparse.Namespace, compared: Comparison) -> str:
    """The comparison for people: one table a quantity, and the changes."""
    lines = []
    for quantity, row in zip(compared.quantities, compared.values, strict=True):
        lines.append(f"{quantity.name} [{quantity.unit}]")
        for dive, value in zip(compared.dives, row, strict=True):
            lines.append(value_line(dive, value))
    lines.append("")
    changes = compared.changes
    for dive, quantity, value in changes:
        lines.append(f"{dive}: {quantity.axis} {quantity.kind} {change_words(value)}")
    for dive, found in explanations(compared).items():
        fits = "; or ".join(found) if found else "no single cause that was tested fits all inertias and drags"
        lines.append(f"{dive}: {fits}")
    if not changes:
        lines.append("no change proven")
    lines += [each.sentence for each in compared.shown]
    lines.append(f"The dives are {compared.order}.")
    lines.append(f"The chance of any false change over these {len(compared.dives)} dives is at most 5 %.")
    lines += ["", *good_enough_lines([_noticed(compared)]), "", next_line(*_next(args, compared))]
    return "\n".join(lines)


def value_line(dive: str, value: Value) -> str:
    """A dive's value with its interval, beside that of the dives before."""
    against = ""
    if value.reference is not None:
        against = f"  before {value.reference:.4g}, p = {value.p_value:.2g}, least change {value.smallest:.2g}"
    mark = "  CHANGED" if value.changed else ""
    return f"  {dive:<24}{value.estimate:>10.4g} ({value.low:.4g} to {value.high:.4g}){against}{mark}"


def change_words(value: Value) -> str:
    """By how much a value changed against the dives before, with an interval of 95 %, and how sure that is."""
    before, before_error = value.reference or 0.0, value.reference_error or 0.0
    certainty = f"p = {value.p_value:.1g}"
    if not before or value.estimate / before <= 0.0:
        return f"changed from {before:.4g} to {value.estimate:.4g} from this dive on ({certainty})"
    ratio = value.estimate / before
    spread = math.hypot(value.error / value.estimate, before_error / before)
    ends = (ratio * math.exp(side * NORMAL_95_DEVIATIONS * spread) for side in (0.0, -1.0, 1.0))
    by, low, high = (f"{100.0 * (each - 1.0):+.0f}" for each in ends)
    return f"changed by {by} % from this dive on (95 %: {low} to {high} %; {certainty})"


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
