"""`incsvr forecast`: asks a running learner where yaw rate and heading go, since the gyro was lost or under a plan."""

from __future__ import annotations

import argparse
import csv
import math
import sys
from pathlib import Path

import numpy as np

from incsvr.errors import BadInput
from incsvr.plant.axes import AXES, YAW, Axis
from incsvr.plant.words import said
from service import wire
from service.client import NoAnswer, reaching
from service.config import Config
from service.config_sources import add_config_arguments, from_arguments
from service.output import add_json_argument, emit
from service.wire import ForecastQuery, ForecastReply

SHOWN = 20
"""Rows for people, evenly spread; all of them go into the JSON object."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--torque", type=float, metavar="N_M", help="this torque from the last measurement on [N m]")
    parser.add_argument("--seconds", type=float, default=20.0, help="for so long, with --torque [s] (default 20)")
    parser.add_argument(
        "--profile",
        type=Path,
        metavar="FILE.csv",
        help="a torque that is planned: columns t [s since the last measurement] and torque [N m]",
    )
    parser.add_argument("--wait", type=float, default=5.0, help="how long to try [s] (default 5)")
    add_config_arguments(parser)
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    config = from_arguments(args)
    asked = _asked(args)
    try:
        reply = ask(config, asked, args.wait)
    except NoAnswer as error:
        print(f"incsvr forecast: {error}", file=sys.stderr)
        return 1
    emit(args, reply.model_dump(mode="json"), text(reply, AXES[config.vehicle.axis]))
    return 0


def ask(config: Config, asked: ForecastQuery | None, patience_s: float) -> ForecastReply:
    """The learner's answer; while it restarts the question is asked again.

    Raises:
        NoAnswer: nobody answers within the time, or nothing has been learned until then.
        BadInput: the learner refuses the question.
    """
    with reaching(config, patience_s) as client:
        payload = None if asked is None else wire.encode(asked)
        return client.ask(client.keys.forecast, ForecastReply, payload)


def text(reply: ForecastReply, axis: Axis = YAW) -> str:
    """The answer for people."""
    lines = [
        said(axis, f"last measurement: {reply.measured:.4g} rad/s at {reply.since:.10g} s; intervals of 95 %"),
        "",
        said(axis, "   after s   yaw rate rad/s   from        to          heading turned rad   from        to"),
    ]
    rows = np.unique(np.linspace(0, len(reply.t) - 1, SHOWN).round().astype(int)).tolist()
    for k in rows:
        left = "" if reply.worth[k] else "   no longer worth having"
        lines.append(
            f"{reply.t[k] - reply.since:10.2f}   {reply.rate[k]:14.4f}   {reply.rate_low[k]:<9.4f}   "
            f"{reply.rate_high[k]:<9.4f}   {reply.turned[k]:18.4f}   {reply.turned_low[k]:<9.4f}   "
            f"{reply.turned_high[k]:<9.4f}{left}"
        )
    return "\n".join([*lines, f"iteration {reply.iteration}, revision {reply.revision}"])


def _asked(args: argparse.Namespace) -> ForecastQuery | None:
    """What is planned; None for what came since the last measurement."""
    if args.torque is not None and args.profile is not None:
        raise BadInput("give either --torque for a constant one or --profile for one that changes, not both")
    if args.torque is not None:
        if not (math.isfinite(args.torque) and math.isfinite(args.seconds) and args.seconds > 0.0):
            raise BadInput("--torque and --seconds: give finite numbers, and more than 0 s")
        t = np.linspace(0.0, args.seconds, 41)
        return ForecastQuery(t=tuple(t.tolist()), torque=(args.torque,) * t.size)
    if args.profile is None:
        return None
    try:
        with args.profile.open(newline="", encoding="utf-8-sig") as file:
            rows = list(csv.DictReader(file))
        times, torque = (tuple(float(row[name]) for row in rows) for name in ("t", "torque"))
        return ForecastQuery(t=times, torque=torque)
    except OSError as error:
        raise BadInput(f"{args.profile}: cannot be read ({error.strerror}); give a CSV file") from None
    except (KeyError, TypeError, ValueError):
        raise BadInput(
            f"{args.profile}: give a CSV file with the columns t and torque, at most 5000 rows of finite numbers"
        ) from None
