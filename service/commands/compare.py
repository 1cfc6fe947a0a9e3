"""`incsvr compare`: compares dives of one vehicle, or the stored coefficients of many, and tells what changed when."""

from __future__ import annotations

import argparse
from pathlib import Path

from service.cli.output import add_json_argument, refuse_unwritable
from service.commands.arguments import (
    add_configuration_arguments,
    add_report_argument,
    emit_with_report,
    provenance,
)
from service.commands.compare_tables import is_dive_table, run_on_tables, write_dives
from service.fitting.compare import compare, explanations
from service.fitting.identify import TAKES
from service.fitting.request import Request
from service.recordings.reading import add_log_arguments


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
    add_configuration_arguments(parser, TAKES)
    parser.add_argument(
        "--table", type=Path, metavar="FILE.parquet", help="file for one row a dive and quantity (Parquet)"
    )
    add_report_argument(parser)
    add_log_arguments(parser, config=True, axis=False)
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    if args.table is not None:
        refuse_unwritable(args.table, "--table")
    if any(is_dive_table(path) for path in args.dives):
        return run_on_tables(args)
    result = compare(Request.of(args, "dives"))
    if args.table is not None:
        write_dives(args.table, result.compared, args.name)
    found = result.compared
    emit_with_report(
        args,
        result.to_dict(),
        str(result),
        lambda report: report.dives_page(found, explanations(found), provenance(args)),
    )
    return 0
