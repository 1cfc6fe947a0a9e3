"""The configuration of a command over logs: that of `--config`, and over it what `--vehicle` and `--set` declare."""

from __future__ import annotations

import argparse
from collections.abc import Collection
from pathlib import Path
from typing import Any

from incsvr.errors import BadInput
from incsvr.signals.settings import TorqueKind
from service.cli.parser import one_of
from service.config.configuration import Config, merge, validate
from service.config.sources import add_set_argument, set_values
from service.config.vehicle_file import read_vehicle
from service.config.vehicle_learners import body_of

VEHICLE_HELP = "take mass matrix and weight from this vehicle file (`incsvr identify --write`)"


def add_arguments(parser: argparse.ArgumentParser, takes: Collection[str], vehicle: str = "") -> None:
    """Adds `--set` for the values `takes` of the configuration, and `--vehicle` where there is a help for it."""
    if vehicle:
        parser.add_argument("--vehicle", type=Path, metavar="FILE", help=vehicle)
    add_set_argument(parser, f"one value, over --config: of {one_of(tuple(takes))}")
    parser.set_defaults(takes=tuple(takes))


def values_set(args: argparse.Namespace) -> tuple[dict[str, Any], dict[tuple[str, ...], str]]:
    """The values of `--set`, nested, and the flag that each came from.

    Raises:
        BadInput: the command does not use one of them.
    """
    flags, origin = set_values(args.set)
    for place, flag in origin.items():
        if not any(place[: name.count(".") + 1] == tuple(name.split(".")) for name in args.takes):
            raise BadInput(f"{flag}: this command uses values of {one_of(args.takes)} alone; leave it out")
        if len(place) == 1:
            raise BadInput(f"{flag}: name one value of the section, as `incsvr config show` lists them")
        if place == ("vehicle", "axis"):
            raise BadInput(f"{flag}: give the axis by --axis")
    return flags, origin


def with_flags(config: Config, args: argparse.Namespace) -> Config:
    """The configuration of one learner, with what the flags declare of it in its place.

    Raises:
        BadInput: naming the flag, and what is allowed there.
    """
    flags, origin = values_set(args)
    axis = args.axis or config.vehicle.axis
    if args.vehicle is not None:
        flags = merge({"vehicle": body_of(read_vehicle(args.vehicle), axis)}, flags)
    if not flags:
        return config
    base = config.model_dump(exclude_unset=True)
    vehicle, signals = (base.setdefault(name, {}) for name in ("vehicle", "signals"))
    if flags.get("vehicle", {}).get("mass_matrix") is not None:
        vehicle.pop("inertia", None)  # the mass matrix says it
    width = flags.get("signals", {}).get("smoothing")
    if isinstance(width, int | float) and signals.get("gap") is not None:
        signals["gap"] = min(signals["gap"], 2.0 * width)  # a narrower filter bridges no longer pauses than it may
    return validate(merge(base, merge(flags, {"vehicle": {"axis": axis}})), origin)


def torque_set(config: Config, args: argparse.Namespace) -> TorqueKind | None:
    """What the torque is, where `--set signals.torque` says it."""
    return config.signals.torque if "torque" in names_set(args, "signals") else None


def names_set(args: argparse.Namespace, section: str) -> frozenset[str]:
    """The names of a section that `--set` sets."""
    return frozenset(set_values(args.set)[0].get(section, {}))
