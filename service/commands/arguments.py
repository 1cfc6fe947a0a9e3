"""The arguments that several commands have in common, and the head of their reports."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Callable, Collection, Mapping
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from types import ModuleType
from typing import Any

from service.cli.extras import reports
from service.cli.output import add_json_argument, emit, report_destination
from service.cli.parser import one_of
from service.config.sources import add_client_arguments, add_set_argument
from service.logs.dives import DIVE_RULE

UNSEEN_HELP = "unseen recordings, used for validation alone"
POLICY_HELP = "policy that selects the samples to keep (default: weighted, or as configured)"


def add_question_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments of a command that asks a learner, after those that say what."""
    add_client_arguments(parser)
    add_json_argument(parser)


def add_recordings_arguments(parser: argparse.ArgumentParser, unseen: str, rule: str = f"; {DIVE_RULE}") -> None:
    """Adds recordings and `--validate`; what is not learned, and the `rule` of one dive, are words of the help."""
    parser.add_argument("recordings", nargs="+", type=Path, metavar="RECORDING", help=f"logs of any format{rule}")
    parser.add_argument("--validate", nargs="+", type=Path, default=[], metavar="RECORDING", help=unseen)


VEHICLE_HELP = "take mass matrix and weight from this vehicle file (`incsvr identify --write`)"


def add_configuration_arguments(parser: argparse.ArgumentParser, takes: Collection[str], vehicle: str = "") -> None:
    """Adds `--set` for the values `takes` of the configuration, and `--vehicle` where there is a help for it."""
    if vehicle:
        parser.add_argument("--vehicle", type=Path, metavar="FILE", help=vehicle)
    add_set_argument(parser, f"one value, over --config: of {one_of(tuple(takes))}")


def add_sign_argument(parser: argparse.ArgumentParser) -> None:
    """Adds `--assume-sign`, the way past a sign that is doubted."""
    parser.add_argument(
        "--assume-sign",
        action="store_true",
        help="use the torque's sign as recorded, even if the motion contradicts it",
    )


def add_report_argument(parser: argparse.ArgumentParser) -> None:
    """Adds `--report`."""
    parser.add_argument(
        "--report", type=report_destination, metavar="FILE.html", help="write a report as one self-contained file"
    )


def emit_with_report(
    args: argparse.Namespace, result: Mapping[str, Any], text: str, page: Callable[[ModuleType], object]
) -> None:
    """Prints the result, and keeps it whatever becomes of the report, which `page` makes by the module that draws.

    That is loaded where `--report` was given, so that learning and tracing need no drawing library.
    """
    try:
        emit(args, result, text)
    finally:
        if args.report:
            drawn = reports()
            drawn.save(page(drawn), args.report)


def provenance(args: argparse.Namespace) -> dict[str, str]:
    """Recordings, command line, software and date, each by what to call it."""
    named = {
        "recordings": getattr(args, "recordings", None) or args.dives,
        "validated on": getattr(args, "validate", None),
    }
    return {
        **{name: ", ".join(path.name for path in paths) for name, paths in named.items() if paths},
        "command": shlex.join(["incsvr", *sys.argv[1:]]),
        "software": f"incsvr {version('incsvr')}, numpy {version('numpy')}, scipy {version('scipy')}",
        "date": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
    }
