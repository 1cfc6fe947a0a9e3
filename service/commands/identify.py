"""`incsvr identify`: the model of a whole vehicle from recordings, and its errors on unseen ones."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

from incsvr.errors import BadInput
from incsvr.plant.axes import AXES
from incsvr.plant.mass_and_coriolis import mass_matrix
from incsvr.vehicle import Identified, WholeMotion, identify, on_grid
from incsvr.vehicle.identify import STEPS
from service.cli.output import add_json_argument, emit, refuse_replacing, writing
from service.cli.progress import progress
from service.commands import log_configuration
from service.commands.arguments import add_report_argument
from service.commands.identify_refusals import refuse_runaway, refuse_stuck
from service.commands.identify_text import text
from service.commands.report_head import REPORT_WRITER, provenance
from service.config.configuration import Config
from service.config.sources import read as read_config
from service.config.vehicle_entries import is_name
from service.config.vehicle_file import MARK, read_values, write_vehicle
from service.number import number_of
from service.recordings.body_reading import read_body
from service.recordings.log_refusals import refuse_implausible, refuse_twice
from service.recordings.reading import Reading, add_log_arguments
from service.recordings.recording import Recording
from service.wire.section import entries_of

TAKES = ("inputs", "vehicle.mass_matrix")
"""The values of the configuration that `identify` and `compare` use."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "recordings", nargs="+", type=Path, metavar="RECORDING", help="logs of any format, one dive each"
    )
    parser.add_argument(
        "--validate",
        nargs="+",
        type=Path,
        default=[],
        metavar="RECORDING",
        help="further dives, used for the errors alone",
    )
    parser.add_argument("--name", default="vehicle", metavar="NAME", help="name of the vehicle (default vehicle)")
    log_configuration.add_arguments(parser, TAKES, "declare the known entries of the mass matrix of this vehicle file")
    parser.add_argument("--write", type=Path, metavar="FILE", help="file for the vehicle model (YAML)")
    add_report_argument(parser)
    add_log_arguments(parser, config=True, axis=False)
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    found, notes = answer(args)
    words = "\n".join([*(f"note: {note}" for note in notes), *([""] if notes else []), text(found)])
    if args.write is not None:
        words += f"\n\nwritten to {args.write}; `incsvr export {args.write} --format python` makes a simulator of it"
    try:
        emit(args, {**found.to_dict(), "notes": list(notes)}, words)
    finally:
        if args.report:
            import_module(REPORT_WRITER).write_vehicle(found, args.report, notes, provenance(args))
    return 0


Began = Callable[[str, int], None]
"""Callback that is given each step as it begins, and the number of steps."""


def answer(args: argparse.Namespace, began: Began = lambda step, count: None) -> tuple[Identified, tuple[str, ...]]:
    """The identified model, written to `--write`, and the notes of the readers."""
    if args.write is not None:
        refuse_replacing(args.write, MARK, "--write")
    if not is_name(args.name):
        raise BadInput("--name: give the vehicle a name of one line")
    given = {} if args.vehicle is None else declared_by_file(args.vehicle)
    config, masses = configured(args)
    given |= masses
    reading = Reading.of(args, config)
    runs, unseen = read_body(reading, args.recordings), read_body(reading.whole, args.validate)
    refuse_twice([*runs, *unseen])
    for run in (*runs, *unseen):
        refuse_implausible(run)
    motion = on_grid([run.body_streams() for run in runs])
    test = on_grid([run.body_streams() for run in unseen], motion.step) if unseen else None
    if test is not None:
        _refuse_other_axes(motion, test, unseen)
    of_file = [f"known inertias of {args.vehicle} are declared, not estimated"] if args.vehicle is not None else []
    notes = tuple(dict.fromkeys((*of_file, *(note for run in (*runs, *unseen) for note in run.notes))))
    count = STEPS + len(motion.axes)
    with progress("identifying", count) as advance:

        def begins(step: str) -> None:
            began(step, count)
            advance(step)

        found = identify(motion, test, given, args.name, begins=begins)
    refuse_stuck(runs, found.vehicle)
    refuse_runaway(motion, found.vehicle)
    if args.write is not None:
        with writing(args.write, "--write"):
            write_vehicle(args.write, found.vehicle)
    return found, notes


def configured(args: argparse.Namespace) -> tuple[Config, dict[tuple[str, str], float]]:
    """The configuration, whose inputs say what is in the logs, and the entries of M that `--set` declares.

    Raises:
        BadInput: naming the flag, and what is allowed there.
    """
    flags, origin = log_configuration.values_set(args)
    mass = flags.pop("vehicle", {}).get("mass_matrix")
    return read_config(args.config, flags, origin), {} if mass is None else declared(mass)


def declared(given: Any) -> dict[tuple[str, str], float]:
    """The entries of M in a value of `vehicle.mass_matrix`; of six numbers, a zero leaves the entry to be estimated.

    Raises:
        BadInput: the entries are no numbers, or of no body.
    """
    found = entries_of(given)
    try:
        entries = [number_of(str(each)) for each in (found if isinstance(found, list) else [found])]
    except ValueError:
        raise BadInput(
            f"--set vehicle.mass_matrix={given}: give six numbers from surge to yaw, or 36, with commas between"
        ) from None
    matrix = mass_matrix(entries)
    names = list(AXES)
    found = {(name, name): float(matrix[k, k]) for k, name in enumerate(names) if matrix[k, k] > 0.0}
    if len(entries) == 36:
        found |= {
            (names[row], names[column]): float(matrix[row, column]) for row in range(6) for column in range(row + 1, 6)
        }
    return found


def declared_by_file(path: Path) -> dict[tuple[str, str], float]:
    """The entries of M in a vehicle file, without those that it says are unknown.

    Raises:
        BadInput: it is no vehicle file.
    """
    found = {}
    for pair, entry in read_values(path)["mass_matrix"].items():
        if entry.get("origin") in (None, "estimated", "declared"):
            row, column = sorted(pair.split(","), key=list(AXES).index)
            found[row, column] = float(entry["value"])
    return found


def _refuse_other_axes(motion: WholeMotion, test: WholeMotion, unseen: list[Recording]) -> None:
    """Refuses dives for the errors that lack a velocity of the model."""
    missing = [name for name in motion.axes if name not in test.axes]
    if missing:
        raise BadInput(
            f"{unseen[0].name}: it lacks {' and '.join(missing)}, which the model predicts; validate on dives with "
            "the same velocities"
        )
