"""`incsvr query`: asks a running learner for the damping at some yaw rates."""

from __future__ import annotations

import argparse
import math
import sys
import threading
import time

import zenoh

from incsvr.errors import BadInput
from service.config import Config, add_config_arguments, from_arguments
from service.output import add_json_argument, emit
from service.session import connecting, from_file, open_session
from service.wire import DampingReply, ErrorReply, Keys, decode

RETRY = 0.3
"""Pause between two attempts while a learner restarts [s]; it is back within one and a half."""


class NoAnswer(Exception):
    """Nobody answered in time; the message is one sentence."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("rates", metavar="RATE", nargs="+", type=float, help="yaw rates [rad/s]")
    parser.add_argument("--wait", type=float, default=5.0, help="how long to try [s] (default 5)")
    add_config_arguments(parser)
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    config = from_arguments(args)
    for rate in args.rates:
        if not math.isfinite(rate):
            raise BadInput(f"{rate} is no yaw rate; give finite numbers in rad/s")
    try:
        reply = ask(config, args.rates, args.wait)
    except NoAnswer as error:
        print(f"incsvr query: {error}", file=sys.stderr)
        return 1
    emit(args, reply.model_dump(mode="json"), table(reply))
    return 0


def ask(config: Config, rates: list[float], patience_s: float) -> DampingReply:
    """The learner's answer; while it restarts the question is asked again.

    Raises:
        NoAnswer: nobody answers within the time, or nothing has been learned until then.
        BadInput: the learner refuses the question.
    """
    bus, keys = config.bus, Keys(config.prefix)
    where = bus.connect or bus.listen
    zenoh_config = connecting(where) if bus.zenoh_file is None else from_file(bus.zenoh_file)
    if bus.zenoh_file is not None:
        where = f"the endpoint of {bus.zenoh_file}"
    until = time.monotonic() + patience_s
    try:
        session = open_session(zenoh_config, patience_s)
    except BadInput as error:
        raise NoAnswer(f"nobody answers at {where}: start `incsvr serve`, or name its place with --connect") from error
    with session:
        return _ask(session, keys, ",".join(repr(rate) for rate in rates), until, where)


def _ask(session: zenoh.Session, keys: Keys, rates: str, until: float, where: str) -> DampingReply:
    pause = threading.Event()
    while True:
        problem = f"a bus is at {where}, but no learner answers for {keys.prefix}: is the prefix right (--prefix)?"
        for reply in session.get(f"{keys.damping}?rate={rates}", timeout=2.0):
            if reply.ok is not None:
                return decode(DampingReply, reply.ok.payload.to_bytes())
            if reply.err is not None:
                refusal = _refusal(reply.err.payload.to_bytes())
                if refusal.error_type == "BadInput":
                    raise BadInput(refusal.error)
                problem = refusal.error
        if time.monotonic() >= until:
            raise NoAnswer(problem)
        pause.wait(RETRY)


def _refusal(payload: bytes) -> ErrorReply:
    """What an error reply says; Zenoh's own, on a timeout, is a bare text."""
    try:
        return decode(ErrorReply, payload)
    except BadInput:
        return ErrorReply(error=f"the bus refuses: {payload.decode(errors='replace')}", error_type="Bus")


def table(reply: DampingReply) -> str:
    """The answer for people."""
    lines = ["yaw rate [rad/s]   damping [N m]   ± sigma [N m]"]
    for rate, damping, sigma, extrapolated in zip(
        reply.rate, reply.damping, reply.sigma, reply.extrapolated, strict=True
    ):
        note = "   extrapolated" if extrapolated else ""
        lines.append(f"{rate:16.4f}   {damping:13.2f}   {sigma:13.2f}{note}")
    return "\n".join([*lines, f"iteration {reply.iteration}, revision {reply.revision}"])
