"""`incsvr compare`: compares dives of one vehicle, or the stored coefficients of many, and tells what changed when."""

from __future__ import annotations

import argparse
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.vehicle import Comparison, compare, on_grid
from incsvr.vehicle.causes import causes
from incsvr.vehicle.changes import LEVEL, Changes
from incsvr.vehicle.history import History
from service.cli.output import add_json_argument, emit, refuse_unwritable
from service.commands import dive_table
from service.commands.arguments import add_report_argument
from service.commands.identify import declared
from service.commands.other_velocities import MASS_MATRIX_HELP
from service.commands.report_head import REPORT_WRITER, provenance
from service.config.sources import read as read_config
from service.recordings.reading import Reading, add_log_arguments

MAX_LINES = 40
"""Changes of a fleet that are printed; all stand in the table and in the JSON."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "dives",
        nargs="+",
        type=Path,
        metavar="DIVE",
        help="logs of any format, in the order of the dives; or tables of dives, of one vehicle or of a fleet",
    )
    parser.add_argument("--name", default="vehicle", metavar="NAME", help="what the vehicle is called (vehicle)")
    parser.add_argument("--mass-matrix", metavar="M", help=MASS_MATRIX_HELP)
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
    document = {"rows": compared.rows(), "vehicle": compared.identified.vehicle.to_dict()}
    return {**document, "explanations": explanations(compared)}


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
    reading = Reading.of(args, read_config(args.config))
    recordings = [reading.of_one(path) for path in args.dives]
    streams = [recording.streams() for recording in recordings]
    step = on_grid(streams).step
    motions = [on_grid([each], step) for each in streams]
    compared = compare(motions, [recording.name for recording in recordings], declared(args.mass_matrix))
    if args.table is not None:
        dive_table.write(args.table, compared, args.name)
    return compared


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
    table, history = dive_table.read(args.dives)
    found = history.changes()
    if args.table is not None:
        dive_table.write_compared(args.table, table, found)
    rows = _changed_rows(table, history, found)
    emit(args, {"coefficients": table.num_rows, "changes": rows}, _text_of_tables(table, history, rows))
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


def _text_of_tables(table: Any, history: History, rows: list[dict[str, Any]]) -> str:
    """The changes of a fleet for people."""
    lines = [
        f"{row['vehicle']}, {row['dive']}: {row['axis']} {row['quantity']} changed by "
        f"{100.0 * (row['estimate'] / row['reference'] - 1.0):+.0f} %"
        for row in rows[:MAX_LINES]
    ]
    if len(rows) > MAX_LINES:
        lines.append(f"and {len(rows) - MAX_LINES} more: --table or --json holds all")
    number = len(history.names[0])
    lines.append(
        f"{len(rows)} changes in {table.num_rows} coefficients of {number} vehicle{'s' * (number != 1)}. The chance of "
        f"any false change of one vehicle over all its dives is at most {100.0 * LEVEL:.0f} %."
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
        speed = "m/s" if quantity.unit in ("N", "kg") else "rad/s"
        at = f" at {quantity.speed:.3g} {speed}" if quantity.kind == "drag" else ""
        lines.append(f"{quantity.axis} {quantity.kind}{at} [{quantity.unit}]")
        for dive, value in zip(compared.dives, row, strict=True):
            against = "" if value.reference is None else f"  before {value.reference:.4g}, p = {value.p_value:.2g}"
            mark = "  CHANGED" if value.changed else ""
            lines.append(f"  {dive:<24}{value.estimate:>10.4g} ({value.low:.4g} to {value.high:.4g}){against}{mark}")
    lines.append("")
    changes = compared.changes
    for dive, quantity, value in changes:
        share = 100.0 * (value.estimate / value.reference - 1.0) if value.reference else float("nan")
        lines.append(f"{dive}: {quantity.axis} {quantity.kind} changed by {share:+.0f} %")
    for dive, found in explanations(compared).items():
        fits = "; or ".join(found) if found else "no single cause that was tested fits all inertias and drags"
        lines.append(f"{dive}: {fits}")
    if not changes:
        lines.append("no change: every dive agrees with those before it")
    lines.append(f"The chance of any false change over these {len(compared.dives)} dives is at most 5 %.")
    return "\n".join(lines)
