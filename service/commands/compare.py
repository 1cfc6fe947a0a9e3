"""`incsvr compare`: compares dives of one vehicle: inertias and drags, and in which dive they changed."""

from __future__ import annotations

import argparse
from importlib import import_module
from pathlib import Path

from incsvr.errors import BadInput
from incsvr.vehicle import Comparison, compare, on_grid
from service.cli.extras import how_to_install
from service.cli.output import add_json_argument, emit, refuse_unwritable
from service.commands.identify import declared
from service.commands.other_velocities import MASS_MATRIX_HELP
from service.config.sources import read as read_config
from service.recordings.reading import Reading, add_log_arguments


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "dives", nargs="+", type=Path, metavar="DIVE", help="logs of any format, in the order of the dives"
    )
    parser.add_argument("--mass-matrix", metavar="M", help=MASS_MATRIX_HELP)
    parser.add_argument(
        "--table", type=Path, metavar="FILE.parquet", help="file for one row a dive and quantity (Parquet)"
    )
    add_log_arguments(parser, config=True, axis=False)
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    if args.table is not None:
        refuse_unwritable(args.table, "--table")
    reading = Reading.of(args, read_config(args.config))
    recordings = [reading.of_one(path) for path in args.dives]
    streams = [recording.streams() for recording in recordings]
    step = on_grid(streams).step
    motions = [on_grid([each], step) for each in streams]
    compared = compare(motions, [recording.name for recording in recordings], declared(args.mass_matrix))
    if args.table is not None:
        _write_parquet(args.table, compared)
    emit(args, {"rows": compared.rows(), "vehicle": compared.identified.vehicle.to_dict()}, text(compared))
    return 0


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
    if not changes:
        lines.append("no change: every dive agrees with those before it")
    lines.append(f"The chance of any false change over these {len(compared.dives)} dives is at most 5 %.")
    return "\n".join(lines)


def _write_parquet(path: Path, compared: Comparison) -> None:
    """Writes one row a dive and quantity."""
    try:
        arrow, parquet = import_module("pyarrow"), import_module("pyarrow.parquet")
    except ModuleNotFoundError:
        raise BadInput(f"--table needs pyarrow, which is not installed: {how_to_install('pyarrow')}") from None
    parquet.write_table(arrow.Table.from_pylist(compared.rows()), path)
