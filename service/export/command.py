"""`incsvr export`: what was learned, in the form of another tool."""

from __future__ import annotations

import argparse
import math
import sqlite3
import sys
from pathlib import Path

from incsvr.errors import BadInput
from service.bus.client import NoAnswer, bus_client
from service.cli.output import refuse_unwritable, writing
from service.config.configuration import Config
from service.config.sources import add_client_arguments, from_arguments
from service.config.vehicle_file import read_vehicle
from service.export import python_vehicle_simulator, simulators, vehicle_simulators
from service.export.damping_model import DampingModel, of_file, of_snapshot
from service.export.rigid_body import parted
from service.export.table import as_csv, as_json
from service.export.vehicle_class import class_module
from service.export.vehicle_remarks import doubts
from service.export.whole_vehicle import python_module
from service.state.state_file import StateDamage, StateFile
from service.wire import ModelSnapshot, decode
from service.wire.json_text import json_text

FORMATS = ("csv", "json", "gazebo", "uuv", "stonefish", "python-vehicle-simulator", "python")
VEHICLE_SUFFIXES = (".yaml", ".yml")
"""Suffixes of a vehicle file, which `incsvr identify --vehicle` writes."""


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
    parser.add_argument(
        "--link", default="base_link", metavar="NAME", help="name of the vehicle's link in Gazebo (base_link)"
    )
    parser.add_argument("--dry-mass", type=float, metavar="M", help="mass of the body alone, for a vehicle file [kg]")
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
    add_client_arguments(parser, whom=" a running learner")


def run(args: argparse.Namespace) -> int:
    if args.out is not None:
        refuse_unwritable(args.out, "--out")
    config = from_arguments(args)
    if config.vehicle.axis != "yaw" and args.format not in ("csv", "json"):
        raise BadInput(
            f"--format {args.format} has a place for yaw alone, but vehicle.axis is {config.vehicle.axis}; take csv or "
            "json, whose N_r, N_r|r| and inertia are then those of that axis"
        )
    if args.source is not None and args.source.suffix in VEHICLE_SUFFIXES:
        text, remarks = _of_vehicle(args)
        status = _written(args, text, f"the vehicle file {args.source}")
        print("\n".join(remarks), end="\n" * bool(remarks), file=sys.stderr)
        return status
    if args.format == "python":
        raise BadInput("--format python takes a vehicle file; `incsvr identify LOG --vehicle vehicle.yaml` writes one")
    try:
        learned = _model(args, config)
    except NoAnswer as error:
        raise NoAnswer(f"{error}; or name a state directory or a trace's JSON") from error
    return _written(args, in_format(learned, args.format, args.link, args.dry_inertia, args.inertia_xy), learned.source)


def _written(args: argparse.Namespace, text: str, source: str) -> int:
    """Writes the text where `--out` says; exit status 0."""
    if args.out is None:
        sys.stdout.write(text)
        return 0
    with writing(args.out, "--out"):
        args.out.write_text(text, encoding="utf-8")
    print(f"{args.out}: {source}", file=sys.stderr)
    return 0


def _of_vehicle(args: argparse.Namespace) -> tuple[str, list[str]]:
    """A vehicle file in the form of a tool, and what is to be known of it.

    Raises:
        BadInput: the file is none, the tool has no form for a whole vehicle, or an inertia is none.
    """
    vehicle = read_vehicle(args.source)
    match args.format:
        case "csv":
            raise BadInput("--format csv has no form for a whole vehicle; take json")
        case "json":
            return json_text(vehicle.to_dict(), indent=2) + "\n", doubts(vehicle)
        case "python":
            return python_module(vehicle), doubts(vehicle)
        case "python-vehicle-simulator":
            return class_module(vehicle), doubts(vehicle)
    given = [args.dry_mass, args.dry_inertia, *(args.inertia_xy or ())]
    _refuse_no_inertias(*(value for value in given if value is not None))
    if (args.dry_inertia is None) != (args.inertia_xy is None):
        raise BadInput("the body's moments of inertia need --dry-inertia and --inertia-xy together, for a vehicle file")
    moments = None if args.inertia_xy is None else (*args.inertia_xy, args.dry_inertia)
    body = parted(vehicle, args.dry_mass, moments)
    match args.format:
        case "gazebo":
            return vehicle_simulators.gazebo(vehicle, body, args.link, args.port_and_up)
        case "uuv":
            return vehicle_simulators.uuv(vehicle, body, args.link, args.port_and_up)
        case _:
            return vehicle_simulators.stonefish(vehicle, body, args.port_and_up)


def in_format(
    learned: DampingModel, format_: str, link: str, dry: float | None = None, across: tuple[float, float] | None = None
) -> str:
    """The learned model in the form of a tool.

    Raises:
        BadInput: the tool has no place for it, or an inertia is none.
    """
    _refuse_no_inertias(*(across or ()), *(() if dry is None else (dry,)))
    if format_ == "csv":
        return as_csv(learned)
    if format_ == "json":
        return json_text(as_json(learned), indent=2) + "\n"
    if format_ == "gazebo":
        return simulators.gazebo(learned, link, dry)
    if format_ == "uuv":
        return simulators.uuv(learned, link, dry)
    if format_ == "stonefish":
        return simulators.stonefish(learned, None if across is None else (across[0], across[1]))
    return python_vehicle_simulator.module(learned)


def _refuse_no_inertias(*values: float) -> None:
    """Refuses what is no mass and no moment of inertia."""
    for value in values:
        if not (math.isfinite(value) and value > 0.0):
            raise BadInput(f"{value:g} is no moment of inertia; give a positive number in kg m² (a mass in kg)")


def _model(args: argparse.Namespace, config: Config) -> DampingModel:
    """The model of the named file or directory, or of the running learner."""
    source: Path | None = args.source
    if source is None:
        with bus_client(config, args.wait) as client:
            snapshot = client.ask(client.keys.model, ModelSnapshot)
        return of_snapshot(snapshot, f"learner {config.prefix}, revision {snapshot.revision}, t = {snapshot.t:.6g} s")
    if source.is_dir():
        source = source / (config.prefix + ".sqlite")
        if not source.is_file():
            raise BadInput(
                f"{source}: there is no such state; name the state directory of `serve`, and its prefix with --prefix"
            )
    return _of_state(source) if source.suffix == ".sqlite" else of_file(source)


def _of_state(path: Path) -> DampingModel:
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
    return of_snapshot(
        decode(ModelSnapshot, row.snapshot), f"state {path.name}, revision {row.revision}, t = {row.t:.6g} s"
    )
