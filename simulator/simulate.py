"""`incsvr simulate`: plays the Leng plant onto the keys.

With `--vehicle FILE --commands LOG` it plays the vehicle of a vehicle file to the learners of all its axes.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

from incsvr.errors import BadInput
from incsvr.plant.axes import AXES
from service.config.configuration import Config
from service.config.sources import from_arguments
from service.config.vehicle_file import read_vehicle
from service.recordings.manoeuvre import read_plan
from service.recordings.reading import Reading, add_log_arguments
from service.recordings.recording import Recording, sequence
from service.recordings.recording_csv import write
from service.wire.json_text import write_json
from simulator import leng
from simulator.leng_at_sea import third_act
from simulator.messages import messages
from simulator.replay import add_player_arguments, play_axes, play_to_learner
from simulator.whole_vehicle import moved_by

MAX_SEED = 2**32 - 1
"""The largest seed of the random numbers."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_player_arguments(parser)
    add_log_arguments(parser, axis=False)
    parser.add_argument(
        "--runs",
        nargs="+",
        choices=("V1", "T1", "V2", "T2"),
        default=["T1", "T2"],
        help="in this order (default T1 T2)",
    )
    parser.add_argument("--seed", type=int, default=1, help="equal seeds give equal runs (default 1)")
    parser.add_argument(
        "--underway", type=int, metavar="SEED", help="seed of an effect that begins in a further act after the runs"
    )
    parser.add_argument(
        "--vehicle",
        metavar="FILE",
        type=Path,
        help="play the vehicle of this vehicle file (`incsvr identify --write`)",
    )
    parser.add_argument(
        "--commands",
        metavar="LOG",
        type=Path,
        help="with --vehicle: a log of any format whose efforts drive the vehicle, or a plan (CSV: t and the efforts)",
    )
    parser.add_argument(
        "--write", metavar="DIR", type=Path, help="folder to write the recordings to instead of playing them"
    )
    parser.add_argument(
        "--truth",
        metavar="FILE",
        type=Path,
        help="write the ground truth, the effect and its time, after the run (--underway)",
    )


def _play_whole_vehicle(args: argparse.Namespace, config: Config, file: Path) -> int:
    """Plays the vehicle of a file, as the efforts of a log drive it, to the learners of its axes."""
    if args.commands is None:
        raise BadInput(f"nothing drives the vehicle of {file}; give a log with its efforts, --commands LOG")
    learners = config.each()
    first = learners[0]
    efforts = read_plan(args.commands)
    if efforts is None:
        efforts = sequence(Reading.of(args, first).of_all([args.commands])).streams()
    recording = moved_by(efforts, read_vehicle(file), f"{first.vehicle.name} under {args.commands.name}")
    if args.write is not None:
        return _written(args.write, [replace(recording, name="whole")])
    learners = (first, *(each for each in learners if first.hears(each)))
    axes = [(each, replace(recording, axis=AXES[each.vehicle.axis])) for each in learners]
    return play_axes(args, axes, recording.name)


def _written(folder: Path, runs: list[Recording]) -> int:
    """Writes recordings instead of playing them. Exit status."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for recording in runs:
            write(folder / f"{recording.name}.csv", recording)
    except OSError as error:
        raise BadInput(f"the recordings cannot be written to {folder} ({error}); name another folder") from error
    return 0


def run(args: argparse.Namespace) -> int:
    config = from_arguments(args, args.vehicle)
    if args.vehicle is not None:
        return _play_whole_vehicle(args, config, args.vehicle)
    if args.commands is not None:
        raise BadInput(f"{args.commands} drives the vehicle of a vehicle file; give one, --vehicle FILE")
    for flag, seed in (("--seed", args.seed), ("--underway", args.underway or 0)):
        if not 0 <= seed <= MAX_SEED:
            raise BadInput(f"{flag} {seed}: give a number from 0 to {MAX_SEED}")
    runs, truth = [leng.recording(name, args.seed) for name in args.runs], None
    if args.underway is not None:
        act, truth = third_act(args.underway)
        runs.append(act)
    if args.write is not None:
        return _written(args.write, runs)
    whole = sequence(runs)
    status = play_to_learner(args, config, messages(whole.streams()), whole.name)
    if truth is not None and args.truth is not None and not status:
        began = float(whole.time[-1] - runs[-1].time[-1])
        write_json(args.truth, truth | {"since": round(began + truth["since"], 1)})
    return status
