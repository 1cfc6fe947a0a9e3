"""The configuration of a command over logs: that of `--config`, and over it the body of a vehicle file."""

from __future__ import annotations

import argparse
from pathlib import Path

from service.config.axes_of_file import body_of_file
from service.config.configuration import Config, merge, validate


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds `--vehicle`."""
    parser.add_argument(
        "--vehicle",
        type=Path,
        metavar="FILE",
        help="use the mass matrix of this vehicle file (`incsvr identify --write`) and, where it has one, its weight",
    )


def with_flags(config: Config, args: argparse.Namespace) -> Config:
    """The configuration of one learner, with what the flags declare of it in its place.

    Raises:
        BadInput: naming the flag, and what is allowed there.
    """
    if args.vehicle is None:
        return config
    axis = args.axis or config.vehicle.axis
    base = config.model_dump(exclude_unset=True)
    base.setdefault("vehicle", {}).pop("inertia", None)  # the mass matrix says it
    return validate(merge(base, {"vehicle": {"axis": axis, **body_of_file(args.vehicle, axis)}}), {})
