"""`incsvr identify`: the model of a whole vehicle from recordings, and its errors on unseen ones."""

from __future__ import annotations

import argparse
from pathlib import Path

from service.cli.output import add_json_argument, refuse_replacing
from service.commands.arguments import (
    add_configuration_arguments,
    add_recordings_arguments,
    add_report_argument,
    emit_with_report,
    provenance,
)
from service.config.vehicle_file import MARK
from service.fitting.identify import TAKES, identify
from service.fitting.request import Request
from service.recordings.reading import add_log_arguments


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_recordings_arguments(parser, "further dives, used for the errors alone", ", one dive each")
    parser.add_argument("--name", default="vehicle", metavar="NAME", help="name of the vehicle (default vehicle)")
    add_configuration_arguments(parser, TAKES, "declare the known entries of the mass matrix of this vehicle file")
    parser.add_argument("--write", type=Path, metavar="FILE", help="file for the vehicle model (YAML)")
    add_report_argument(parser)
    add_log_arguments(parser, config=True, axis=False)
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    if args.write is not None:
        refuse_replacing(args.write, MARK, "--write")
    result = identify(Request.of(args))
    if args.write is not None:
        result = result.write(args.write)
    words = "\n".join([*(f"note: {note}" for note in result.notes), *([""] if result.notes else []), str(result)])
    emit_with_report(
        args,
        result.to_dict(),
        words,
        lambda report: report.vehicle_page(result.found, result.notes, provenance(args)),
    )
    return 0
