"""`incsvr replay`: plays recorded runs onto the keys, at their own pace or faster; an archive byte for byte."""

from __future__ import annotations

import argparse
import logging
import math
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.axes import AXES, stream_of
from incsvr.signals import REQUIRED
from service.bus.session import BusRefusal, client_config, nobody_at, open_session, stop_event
from service.cli.progress import progress
from service.config.configuration import Config
from service.config.sources import add_config_arguments, from_arguments
from service.logs.cutting import Cut
from service.logs.dives import DIVE_RULE
from service.recordings.archive_reader import ArchiveReader, is_archive
from service.recordings.reading import Reading, add_log_arguments
from service.recordings.recording import Recording, sequence
from service.wire import Keys
from simulator.intake import Intake
from simulator.messages import Messages, messages
from simulator.player import play, wait_for_learner


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "recordings", metavar="RECORDING", nargs="+", type=Path, help=f"logs of any format; {DIVE_RULE}"
    )
    add_log_arguments(parser)
    add_player_arguments(parser)


def add_player_arguments(parser: argparse.ArgumentParser) -> None:
    """The flags that `simulate` and `replay` share."""
    add_config_arguments(parser)
    parser.add_argument("--speed", type=float, default=1.0, help="speed over the vehicle's own (default 1)")
    parser.add_argument(
        "--patient",
        action="store_true",
        help="pause while the learner traces, so that the ledger is the same at any speed",
    )
    parser.add_argument("--wait", type=float, default=30.0, help="how long to wait for a learner [s] (default 30)")


def run(args: argparse.Namespace) -> int:
    learners = from_arguments(args).each()
    config = learners[0]
    if is_archive(args.recordings[0]):
        kept = ArchiveReader.read(args.recordings).within(Cut.of(args))
        return play_to_learner(args, config, kept, kept.name)
    recording = sequence(Reading.of(args, config).of_all(args.recordings))
    others = [] if args.axis is not None else _of_other_axes(args, learners)
    return play_axes(args, [(config, recording), *others], recording.name)


def play_axes(args: argparse.Namespace, axes: Sequence[tuple[Config, Recording]], name: str) -> int:
    """Plays a vehicle's motion, as each of its learners takes it, to all of them. Exit status.

    Each learner gets the streams of its own axis, but those that it takes from another learner, and the first one also
    what no other has.
    """
    learners = [learner for learner, _ in axes]
    streams = dict[str, tuple[Array, Array]]()
    for learner, recording in axes:
        own, others = AXES[learner.vehicle.axis], [AXES[each.vehicle.axis] for each in learners if each is not learner]
        theirs = {name for each in others for name in (stream_of(own, each.rate), each.effort)}
        for stream, values in recording.streams().items():
            elsewhere = stream in learner.signal_settings().channels and any(
                stream in learner.hears(other) for other in learners
            )
            if not elsewhere and (stream in REQUIRED or (learner is learners[0] and stream not in theirs)):
                streams[Keys(learner.prefix).stream(stream)] = values
    what = messages(streams, whole_keys=True)
    return play_to_learner(args, learners[0], what, name, [each.prefix for each in learners[1:]])


def _of_other_axes(args: argparse.Namespace, learners: Sequence[Config]) -> list[tuple[Config, Recording]]:
    """The recordings, read for each learner of another axis of the vehicle; one that they do not hold is said."""
    found = []
    for learner in learners[1:]:
        if not learners[0].hears(learner):
            continue
        try:
            found.append((learner, sequence(Reading.of(args, learner).of_all(args.recordings))))
        except BadInput as error:
            print(f"incsvr replay: {learner.prefix} is not played: {error}", file=sys.stderr)
    return found


def play_to_learner(
    args: argparse.Namespace, config: Config, what: Messages | ArchiveReader, name: str, others: Sequence[str] = ()
) -> int:
    """Plays messages to the learner of the configuration, and of other prefixes; shows how far it is. Exit status."""
    if not (math.isfinite(args.speed) and args.speed > 0.0):
        raise BadInput(f"--speed {args.speed}: give a positive number, 1 for the vehicle's own pace")
    stop = stop_event()
    logging.basicConfig(level=logging.INFO, stream=sys.stderr, format=f"incsvr {args.command}: %(message)s")
    learners = [Keys(config.prefix), *map(Keys, others)]
    try:
        session = open_session(client_config(config.bus), args.wait, stop)
    except BusRefusal:
        raise
    except BadInput:
        if stop.is_set():  # told to stop while it waited: that needs no word
            return 1
        raise BadInput(nobody_at(config.bus)) from None
    with session:
        for each in learners if args.wait > 0.0 else ():
            wait_for_learner(session, each, args.wait, stop)
        seconds, began = float(what.send[-1] - what.send[0]) if len(what) else 0.0, time.monotonic()
        intakes = [Intake(session, each, stop, config.learner.batch) for each in learners]
        with progress(f"playing {name}, {seconds:.0f} s", int(seconds)) as second:
            sent = play(session, learners[0], what, speed=args.speed, stop=stop, second=second, intake=intakes[0],
                        patient=args.patient)  # fmt: skip
        if sent < len(what):
            return 1
        took = time.monotonic() - began
        print(f"incsvr {args.command}: played {seconds:.0f} s, {sent:,} messages, in {took:.0f} s", file=sys.stderr)
        for intake in intakes:
            if (sentence := intake.loss(what, min(args.speed, seconds / took))) is not None:
                print(f"incsvr {args.command}: {sentence}", file=sys.stderr)
    return 0
