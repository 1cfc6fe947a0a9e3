"""`incsvr trace`: reads recordings, traces what the model lacks, prints it for people or for programs."""

from __future__ import annotations

import argparse

from service.cli.output import add_json_argument
from service.commands.arguments import (
    UNSEEN_HELP,
    VEHICLE_HELP,
    add_configuration_arguments,
    add_recordings_arguments,
    add_report_argument,
    add_sign_argument,
    emit_with_report,
    provenance,
)
from service.fitting.request import Request
from service.fitting.trace import TAKES, trace
from service.recordings.reading import add_log_arguments


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_recordings_arguments(parser, UNSEEN_HELP)
    parser.add_argument(
        "--inertia", metavar="I", help="declared I [kg m²], or estimate; else vehicle.inertia of --config"
    )
    add_configuration_arguments(parser, TAKES, VEHICLE_HELP)
    add_report_argument(parser)
    add_sign_argument(parser)
    add_log_arguments(parser, config=True)
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    traced = trace(Request.of(args), None if args.json == "-" else args.json)
    emit_with_report(
        args,
        traced.to_dict(),
        str(traced),
        lambda report: report.trace_page(traced.found, traced.axis, provenance(args)),
    )
    return 0
