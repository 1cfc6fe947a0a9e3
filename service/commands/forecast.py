"""`incsvr forecast`: asks a running learner where yaw rate and heading go, since the gyro was lost or under a plan."""

from __future__ import annotations

import argparse
import csv
import math
from pathlib import Path

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics.plain import to_plain
from incsvr.plant.axes import YAW, Axis
from incsvr.plant.words import words_of
from service import wire
from service.bus.client import Client, bus_client
from service.cli.output import emit
from service.commands.arguments import add_question_arguments
from service.config.sources import from_arguments
from service.health.health_watch import MIN_SILENCE_S
from service.number import number_of
from service.wire import ForecastQuery, ForecastReply, Health, StreamHealth

SHOWN_ROWS = 20
"""Rows for people, evenly spread; all of them go into the JSON object."""
MIN_ROW_GAP_S = 0.05
"""Between two rows for people at least [s]: a vehicle hardly turns meanwhile."""
CONSTANT_TORQUE_S = 20.0
"""The default duration of a constant planned torque [s]."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--torque", type=float, metavar="N_M", help="constant torque from the last measurement on [N m]"
    )
    parser.add_argument(
        "--seconds",
        type=float,
        help="duration [s] (default 20 with --torque); without --torque, under the present torque",
    )
    parser.add_argument(
        "--profile",
        type=Path,
        metavar="FILE.csv",
        help="CSV file of a planned torque: columns t [s since the last measurement] and torque [N m]",
    )
    add_question_arguments(parser)


def run(args: argparse.Namespace) -> int:
    config = from_arguments(args)
    planned, axis = _planned(args), config.axis_asked
    with bus_client(config, args.wait) as client:
        note = None
        if planned is None:
            planned, note = _without_plan(client, args.seconds, axis)
        payload = None if planned is None else wire.encode(planned)
        reply = client.ask(client.keys.forecast, ForecastReply, payload)
    emit(args, to_plain(reply), "\n".join([*([note] if note else []), text(reply, axis)]))
    return 0


def _without_plan(client: Client, seconds: float | None, axis: Axis) -> tuple[ForecastQuery | None, str | None]:
    """The query without a planned torque, and the remark that describes it.

    While the gyro works, there is next to nothing between the last measurement and now.
    """
    health = client.ask(client.keys.health, Health)
    torque, rate = (health.streams.get(name, StreamHealth()) for name in ("torque", "yaw_rate"))
    words = words_of(axis)
    heard = "the gyro works" if axis is YAW else f"the {words.rate} arrives"
    note = f"{heard}: give --torque for a plan, such as --torque 20 --seconds 10"
    if seconds is not None and torque.value is not None:
        now = f"{torque.value:.4g} {words.effort_unit}"
        held = f"under the present {words.effort}, {now}, constant for {seconds:g} s"
        return _constant(torque.value, seconds), held
    believed = health.learning.state != "paused"
    return None, note if believed and rate.age_s is not None and rate.age_s <= MIN_SILENCE_S else None


def text(reply: ForecastReply, axis: Axis = YAW) -> str:
    """The answer for people."""
    words = words_of(axis)
    lines = [
        f"last measurement: {reply.measured:.4g} {words.rate_unit} at {reply.since:.10g} s; intervals of 95 %",
        "",
        f"   after s   {words.rate} {words.rate_unit}   from        to          heading turned rad   from        to",
    ]
    shown = min(SHOWN_ROWS, max(2, round((reply.t[-1] - reply.since) / MIN_ROW_GAP_S)))
    rows = np.unique(np.linspace(0, len(reply.t) - 1, shown).round().astype(int)).tolist()
    for k in rows:
        left = "" if reply.worth[k] else "   too uncertain to be useful"
        lines.append(
            f"{reply.t[k] - reply.since:10.2f}   {reply.rate[k]:14.4f}   {reply.rate_low[k]:<9.4f}   "
            f"{reply.rate_high[k]:<9.4f}   {reply.turned[k]:18.4f}   {reply.turned_low[k]:<9.4f}   "
            f"{reply.turned_high[k]:<9.4f}{left}"
        )
    return "\n".join([*lines, f"iteration {reply.iteration}, revision {reply.revision}"])


def _constant(torque: float, seconds: float) -> ForecastQuery:
    """One torque [N m] for so long [s]."""
    if not (math.isfinite(torque) and math.isfinite(seconds) and seconds > 0.0):
        raise BadInput("--torque and --seconds: give finite numbers, and more than 0 s")
    t = np.linspace(0.0, seconds, 41)
    return ForecastQuery(t=tuple(t.tolist()), torque=(torque,) * t.size)


def _planned(args: argparse.Namespace) -> ForecastQuery | None:
    """The torque that is planned; None where none is."""
    if args.torque is not None and args.profile is not None:
        raise BadInput("give either --torque for a constant one or --profile for one that changes, not both")
    if args.seconds is not None and args.profile is not None:
        raise BadInput("--seconds is for a constant torque; the column t of --profile gives the duration")
    if args.torque is not None:
        return _constant(args.torque, CONSTANT_TORQUE_S if args.seconds is None else args.seconds)
    if args.profile is None:
        return None
    try:
        with args.profile.open(newline="", encoding="utf-8-sig") as file:
            rows = list(csv.DictReader(file))
        times, torque = (tuple(number_of(row[name]) for row in rows) for name in ("t", "torque"))
        return ForecastQuery(t=times, torque=torque)
    except OSError as error:
        raise BadInput(f"{args.profile}: cannot be read ({error.strerror}); give a CSV file") from None
    except (KeyError, TypeError, ValueError):
        raise BadInput(
            f"{args.profile}: give a CSV file with the columns t and torque, at most 5000 rows of finite numbers"
        ) from None
