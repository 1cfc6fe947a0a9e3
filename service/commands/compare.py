"""`incsvr compare`: compares dives of one vehicle, or the stored coefficients of many, and tells what changed when."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.vehicle import Comparison, compare, on_grid
from incsvr.vehicle.causes import causes
from incsvr.vehicle.changes import LEVEL, Changes
from incsvr.vehicle.compare import Value
from incsvr.vehicle.history import History
from incsvr.vehicle.shown import Shown
from service.cli.output import add_json_argument, emit, refuse_unwritable
from service.commands import dive_table, log_configuration
from service.commands.arguments import add_report_argument
from service.commands.change_text import change_words, value_line
from service.commands.identify import TAKES, configured
from service.commands.report_head import REPORT_WRITER, provenance
from service.logs.cutting import MIN_STAMP_SINCE_1970_S
from service.recordings.body_reading import read_body
from service.recordings.log_refusals import DIVE_GIVEN_TWICE, refuse_implausible, refuse_twice
from service.recordings.reading import Reading, add_log_arguments
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
    if any(dive_table.is_dive_table(path) for path in args.dives):
        if args.table is not None:
            refuse_unwritable(args.table, "--table")
        return _run_on_tables(args)
    compared = answer(args)
    if args.report:
        import_module(REPORT_WRITER).write_dives(compared, explanations(compared), args.report, _made_of(args))
    emit(args, to_dict(compared), text(compared))
    return 0


def to_dict(compared: Comparison) -> dict[str, Any]:
    """The comparison for programs: the JSON of `--json`."""
    return {
        "rows": compared.rows(),
        "order": compared.order,
        "shown": [each.to_dict() for each in compared.shown],
        "vehicle": compared.identified.vehicle.to_dict(),
        "explanations": explanations(compared),
    }


def answer(args: argparse.Namespace) -> Comparison:
    """The comparison of logs, written to `--table`.

    Raises:
        BadInput: a log cannot be used, or is a table of dives.
    """
    if args.table is not None:
        refuse_unwritable(args.table, "--table")
    for path in args.dives:
        if dive_table.is_dive_table(path):
            raise BadInput(f"{path}: is a table of dives, which only the command incsvr compare takes; give logs")
    config, masses = configured(args)
    reading = Reading.of(args, config)
    recordings = [read_body(reading, [path])[0] for path in args.dives]
    refuse_twice(recordings, DIVE_GIVEN_TWICE)
    for recording in recordings:
        refuse_implausible(recording)
    recordings, order = _in_order(recordings)
    streams = [recording.body_streams() for recording in recordings]
    step = on_grid(streams).step
    motions = [on_grid([each], step) for each in streams]
    compared = compare(motions, [recording.name for recording in recordings], masses)
    compared = replace(compared, order=order)
    if args.table is not None:
        dive_table.write(args.table, compared, args.name)
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


def _made_of(args: argparse.Namespace) -> dict[str, str]:
    """What a report is made of."""
    return provenance(argparse.Namespace(recordings=args.dives, validate=[]))


def _run_on_tables(args: argparse.Namespace) -> int:
    """Compares stored coefficients."""
    for path in args.dives:
        if not dive_table.is_dive_table(path):
            raise BadInput(f"{path}: is no table of dives; compare either logs or tables of dives")
    if args.report:
        raise BadInput("--report needs the logs of one vehicle's dives; of tables, --table writes what was found")
    table, history = dive_table.read(args.dives, whole=args.table is not None)
    found = history.changes()
    if args.table is not None:
        dive_table.write_compared(args.table, table, found)
    rows, seen = _changed_rows(table, history, found), history.shown(found, table.column("dive"))
    document = {"coefficients": table.num_rows, "changes": rows, "shown": [each.to_dict() for each in seen]}
    emit(args, document, _text_of_tables(rows, history, found, seen))
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


def text(compared: Comparison) -> str:
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
    return "\n".join(lines)
