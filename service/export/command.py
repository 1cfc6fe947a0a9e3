"""`incsvr export`: what was learned, in the form of another tool."""

from __future__ import annotations

import argparse
import shlex
import sqlite3
import sys
from pathlib import Path

from incsvr.errors import BadInput
from incsvr.vehicle import Vehicle
from incsvr.vehicle.model import beaten
from service.bus.client import NoAnswer, bus_client
from service.cli.next_command import next_line
from service.cli.output import refuse_unwritable, writing
from service.config.configuration import Config
from service.config.sources import add_client_arguments, from_arguments
from service.config.vehicle_file import read_vehicle
from service.export.formats import doubts, gazebo, parted, python_module, stonefish, table, vehicle_figures
from service.export.learned import Learned, of_file, of_snapshot
from service.state.state_file import StateDamage, StateFile
from service.wire import ModelSnapshot, decode
from service.wire.json_text import json_text

FORMATS = ("csv", "json", "gazebo", "stonefish", "python", "casadi")
RUNNABLE = ("python", "casadi")
"""Formats that are programs."""
VEHICLE_SUFFIXES = (".yaml", ".yml")
"""Suffixes of a vehicle file, which `incsvr identify --write` writes."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "source",
        nargs="?",
        type=Path,
        metavar="SOURCE",
        help="a state directory or its .sqlite file, a result of `trace --json` or `fit --json`, or a vehicle "
        "file (default: a running learner)",
    )
    parser.add_argument("--format", choices=FORMATS, default="json", help="format of the output (default json)")
    parser.add_argument("--out", type=Path, metavar="FILE", help="write to this file instead of standard output")
    parser.add_argument("--dry-mass", type=float, metavar="M", help="mass of the body alone [kg]")
    parser.add_argument("--dry-inertia", type=float, metavar="I", help="inertia of the body alone about yaw [kg m²]")
    parser.add_argument(
        "--inertia-xy",
        nargs=2,
        type=float,
        metavar=("IX", "IY"),
        help="inertias of the body alone about roll and pitch [kg m²]",
    )
    parser.add_argument(
        "--port-and-up",
        action="store_true",
        help="the axes of the vehicle file are to port and up, as in ROS (SNAME: to starboard and down)",
    )
    parser.add_argument(
        "--force",
        action="store_true",
        help="export a model even where a velocity of zero, or the first one kept, predicts unseen data better",
    )
    add_client_arguments(parser, whom=" a running learner")


def run(args: argparse.Namespace) -> int:
    if args.out is not None:
        refuse_unwritable(args.out, "--out")
    model: Learned | Vehicle
    if args.source is not None and args.source.suffix in VEHICLE_SUFFIXES:
        model, source = read_vehicle(args.source), f"the vehicle file {args.source}"
    else:
        try:
            model = _model(args, from_arguments(args))
        except NoAnswer as error:
            raise NoAnswer(f"{error}; or name a state directory or a trace's JSON") from error
        source = model.source
    if (why := beaten(model.beaten_by)) and not args.force:
        raise BadInput(f"{source}: {why[0]}, or export it all the same with --force")
    across = None if args.inertia_xy is None else (args.inertia_xy[0], args.inertia_xy[1])
    text, remarks = in_format(model, args.format, args.dry_mass, args.dry_inertia, across, args.port_and_up)
    remarks = [*remarks, next_line(*_next(args))]
    if args.out is None:
        sys.stdout.write(text)
    else:
        with writing(args.out, "--out"):
            args.out.write_text(text, encoding="utf-8")
        remarks = [f"{args.out}: {source}", *remarks]
    print("\n".join(remarks), end="\n" * bool(remarks), file=sys.stderr)
    return 0


def _next(args: argparse.Namespace) -> tuple[str, str]:
    """The command that follows, and what it does."""
    if args.format in RUNNABLE and args.out is not None:
        return shlex.join(["python", str(args.out)]), "simulates a step of each effort"
    source = [] if args.source is None else [str(args.source)]
    given = [word for name in ("config", "prefix", "connect") for word in _given(args, name)]
    force = ["--force"] * args.force
    words = ["incsvr", "export", *source, *given, *force, "--format", "python", "--out", "model.py"]
    return shlex.join(words), "writes a simulator of it"


def _given(args: argparse.Namespace, name: str) -> list[str]:
    value = getattr(args, name)
    return [] if value is None else [f"--{name}", str(value)]


def in_format(
    model: Learned | Vehicle,
    format_: str,
    mass: float | None = None,
    about_yaw: float | None = None,
    across: tuple[float, float] | None = None,
    flu: bool = False,
) -> tuple[str, list[str]]:
    """The model in the form of a tool, and the remarks on it.

    Args:
        mass, about_yaw, across: of the body alone, as in `parted`.
        flu: whether the axes are to port and up.

    Raises:
        BadInput: the body alone is none.
    """
    vehicle = model if isinstance(model, Vehicle) else model.vehicle()
    body = parted(vehicle, mass, about_yaw, across)
    match format_:
        case "gazebo":
            return gazebo(vehicle, body, flu)
        case "stonefish":
            return stonefish(vehicle, body, flu)
        case "csv":
            text = table(model.figures() if isinstance(model, Learned) else vehicle_figures(model))
        case "json":
            text = json_text(model.to_dict(), indent=2) + "\n"
        case _:
            text = python_module(vehicle, format_ == "casadi")
    return text, doubts(vehicle)


def _model(args: argparse.Namespace, config: Config) -> Learned:
    """The model of the named file or directory, or of the running learner."""
    source: Path | None = args.source
    axis = config.vehicle.axis
    if source is None:
        with bus_client(config, args.wait) as client:
            snapshot = client.ask(client.keys.model, ModelSnapshot)
        return of_snapshot(
            snapshot, f"learner {config.prefix}, revision {snapshot.revision}, t = {snapshot.t:.6g} s", axis
        )
    if source.is_dir():
        source = source / (config.prefix + ".sqlite")
        if not source.is_file():
            raise BadInput(
                f"{source}: there is no such state; name the state directory of `serve`, and its prefix with --prefix"
            )
    return _of_state(source, axis) if source.suffix == ".sqlite" else of_file(source)


def _of_state(path: Path, axis: str) -> Learned:
    """The newest revision in a state's file; its learner may be running."""
    try:
        file = StateFile(path)
        try:
            row = file.row(file.newest)
        finally:
            file.close()
    except (StateDamage, sqlite3.Error, OSError) as error:
        raise BadInput(f"{path}: this state cannot be read ({error}); name another, or a running learner") from None
    if row is None:
        raise BadInput(f"{path}: nothing was learned yet; export after the vehicle has turned both ways")
    source = f"state {path.name}, revision {row.revision}, t = {row.t:.6g} s"
    return of_snapshot(decode(ModelSnapshot, row.snapshot), source, axis)
