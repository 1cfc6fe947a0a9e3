"""`incsvr fit`: the online loop over recordings, with the errors of every iteration on unseen recordings."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path

from incsvr.errors import BadInput
from service.cli.next_command import with_next
from service.cli.output import add_json_argument
from service.commands.arguments import (
    POLICY_HELP,
    UNSEEN_HELP,
    VEHICLE_HELP,
    add_configuration_arguments,
    add_recordings_arguments,
    add_report_argument,
    add_sign_argument,
    emit_with_report,
    provenance,
)
from service.fitting.fit import TAKES, fit
from service.fitting.fit_text import text
from service.fitting.request import POLICIES, Request
from service.fitting.written import Destination, base, leave
from service.recordings.reading import add_log_arguments


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_recordings_arguments(parser, UNSEEN_HELP)
    parser.add_argument(
        "--inertia",
        metavar="I",
        help="inertia with added mass [kg m²], or estimate; else vehicle.inertia of --config",
    )
    parser.add_argument(
        "--config",
        type=Path,
        metavar="FILE",
        help="use this configuration's signals and learner; else they are scaled to the recordings",
    )
    add_configuration_arguments(parser, TAKES, VEHICLE_HELP)
    parser.add_argument(
        "--effects", type=Path, metavar="FILE", help="effects of a result of `incsvr trace --json FILE`"
    )
    parser.add_argument("--policy", choices=POLICIES, help=POLICY_HELP)
    parser.add_argument(
        "--write",
        type=Path,
        metavar="FILE",
        help="write a configuration from which `serve` continues; in a file that is there only fitted values change",
    )
    parser.add_argument("--name", metavar="N", help="name of the vehicle in it; its keys then begin with N/AXIS")
    parser.add_argument("--state", type=Path, metavar="DIR", help="directory of the state (default: as FILE has it)")
    parser.add_argument("--force", action="store_true", help="replace a state that is there")
    add_report_argument(parser)
    add_sign_argument(parser)
    add_log_arguments(parser)
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    request, to = Request.of(args), _destination(args)
    found = fit(request, None if to is None else base(to, request))
    result, words = found.to_dict(), str(found)
    if to is not None:
        serve = shlex.join(["incsvr", "serve", "--config", str(args.write)])
        words = with_next(f"{text(found)}\n\n{leave(found, to)}", serve, "continues to learn on the bus")
        result["next"] = serve
    emit_with_report(
        args,
        result,
        words,
        lambda report: report.fit_page(result, found.pictures, found.axis, provenance(args)),
    )
    return 0


def _destination(args: argparse.Namespace) -> Destination | None:
    """Where the fit is left; None without `--write`."""
    if args.write is not None:
        return Destination(args.write, args.name, args.state, args.force)
    given = next((name for name in ("name", "state", "force") if getattr(args, name)), None)
    if given is not None:
        raise BadInput(f"--{given} is about what --write FILE leaves; give both, or none")
    return None
