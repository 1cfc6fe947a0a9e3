"""`incsvr trace`: reads recordings, traces what the model lacks, prints it for people or for programs."""

from __future__ import annotations

import argparse

from service.cli.extras import reports
from service.cli.output import add_json_argument, emit
from service.commands.arguments import (
    VEHICLE_HELP,
    add_configuration_arguments,
    add_recordings_arguments,
    add_report_argument,
    add_sign_argument,
    provenance,
)
from service.fitting.request import Request
from service.fitting.trace import TAKES, trace
from service.recordings.reading import add_log_arguments


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_recordings_arguments(
        parser,
        "unseen recordings, used for validation alone",
        "declared I [kg m²], or estimate; else vehicle.inertia of --config",
    )
    add_configuration_arguments(parser, TAKES, VEHICLE_HELP)
    add_report_argument(parser)
    add_sign_argument(parser)
    add_log_arguments(parser, config=True)
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    traced = trace(Request.of(args), None if args.json == "-" else args.json)
    try:
        emit(args, traced.to_dict(), traced.text)  # before any picture: it is kept whatever becomes of that
    finally:
        if args.report:
            reports().save(reports().trace_page(traced.found, traced.axis, provenance(args)), args.report)
    return 0
