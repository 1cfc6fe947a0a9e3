"""`incsvr simulate`: plays the Leng plant onto the keys; the configuration's `simulation` is the scenario."""

from __future__ import annotations

import argparse
from pathlib import Path

from incsvr.errors import BadInput
from service.config.sources import from_arguments
from service.recordings.manoeuvre import read_manoeuvre
from service.recordings.recording import sequence
from service.recordings.recording_csv import write
from service.wire.json_text import write_json
from simulator import leng, planar, underway
from simulator.messages import Faults, messages
from simulator.replay import add_player_arguments, play_to_learner
from simulator.steered import steered


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_player_arguments(parser)
    parser.add_argument("--write", metavar="DIR", type=Path, help="write the recordings there instead of playing them")
    parser.add_argument(
        "--torque",
        metavar="FILE.csv",
        type=Path,
        help="play the vehicle as this torque steers it (columns t and torque; `incsvr trace --manoeuvre` writes one)",
    )
    parser.add_argument(
        "--truth",
        metavar="FILE",
        type=Path,
        help="write the ground truth, the effect and its time, after the run (simulation.underway)",
    )


def run(args: argparse.Namespace) -> int:
    config = from_arguments(args)
    scenario = config.simulation
    if args.torque is not None and scenario.underway is not None:
        raise BadInput("--torque and simulation.underway play two different acts; leave one of them")
    manoeuvre = None if args.torque is None else read_manoeuvre(args.torque)
    names = scenario.runs if manoeuvre is None else ()
    runs = [] if manoeuvre is None else [steered(args.torque.stem, *manoeuvre, scenario.seed)]
    runs += [
        planar.recording(scenario.seed, vehicle=planar.DEFAULT)
        if name == "planar"
        else leng.recording(name, scenario.seed)
        for name in names
    ]
    act = None if scenario.underway is None else underway.play(scenario.underway)
    if act is not None:
        runs.append(act.recording)
    if args.write is not None:
        try:
            args.write.mkdir(parents=True, exist_ok=True)
            for recording in runs:
                write(args.write / f"{recording.name}.csv", recording)
        except OSError as error:
            raise BadInput(
                f"the recordings cannot be written to {args.write} ({error}); name another folder"
            ) from error
        return 0
    faults = Faults(scenario.drop_outs, scenario.drop_out_length, scenario.jitter, scenario.duplicates)
    whole = sequence(runs)
    status = play_to_learner(args, config, messages(whole.streams(), faults, scenario.seed), whole.name)
    if act is not None and args.truth is not None and not status:
        began = float(whole.time[-1] - act.recording.time[-1])
        truth = {"effect": act.effect, "since": round(began + act.onset, 1), "parameters": act.truth}
        write_json(args.truth, truth)
    return status
