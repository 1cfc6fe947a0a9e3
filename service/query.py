"""`incsvr query`: asks a running learner for the damping at some yaw rates."""

from __future__ import annotations

import argparse
import math
import sys

from incsvr.errors import BadInput
from incsvr.plant.axes import AXES, YAW, Axis
from incsvr.plant.words import said
from service.client import NoAnswer, reaching
from service.config import Config, add_config_arguments, from_arguments
from service.output import add_json_argument, emit
from service.wire import DampingReply


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("rates", metavar="RATE", nargs="+", type=float, help="yaw rates [rad/s]")
    parser.add_argument("--wait", type=float, default=5.0, help="how long to try [s] (default 5)")
    add_config_arguments(parser)
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    config = from_arguments(args)
    axis = AXES[config.vehicle.axis]
    for rate in args.rates:
        if not math.isfinite(rate):
            raise BadInput(said(axis, f"{rate} is no yaw rate; give finite numbers in rad/s"))
    try:
        reply = ask(config, args.rates, args.wait)
    except NoAnswer as error:
        print(f"incsvr query: {error}", file=sys.stderr)
        return 1
    emit(args, reply.model_dump(mode="json"), table(reply, axis))
    return 0


HEADS = (("yaw rate [rad/s]", 16), ("damping [N m]", 13), ("± sigma [N m]", 13))
"""Of the columns, and how wide these are at least."""


def ask(config: Config, rates: list[float], patience_s: float) -> DampingReply:
    """The learner's answer; while it restarts the question is asked again.

    Raises:
        NoAnswer: nobody answers within the time, or nothing has been learned until then.
        BadInput: the learner refuses the question.
    """
    with reaching(config, patience_s) as client:
        asked = ",".join(repr(rate) for rate in rates)
        return client.ask(f"{client.keys.damping}?rate={asked}", DampingReply)


def table(reply: DampingReply, axis: Axis = YAW) -> str:
    """The answer for people."""
    heads = [(said(axis, head), width) for head, width in HEADS]
    lines = ["   ".join(f"{head:>{width}s}" for head, width in heads)]
    for rate, damping, sigma, extrapolated in zip(
        reply.rate, reply.damping, reply.sigma, reply.extrapolated, strict=True
    ):
        note = "   extrapolated" if extrapolated else ""
        cells = zip((f"{rate:.4f}", f"{damping:.2f}", f"{sigma:.2f}"), heads, strict=True)
        lines.append("   ".join(f"{cell:>{max(width, len(head))}s}" for cell, (head, width) in cells) + note)
    return "\n".join([*lines, f"iteration {reply.iteration}, revision {reply.revision}"])
