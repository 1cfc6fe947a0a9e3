"""`incsvr config show` and `incsvr config check FILE`: what is in force, what is wrong."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from service.bus.bus_check import check_bus, check_files
from service.bus.mapped_ingest import mapping
from service.cli.output import add_json_argument, emit
from service.config.config_writer import commented_yaml
from service.config.configuration import check_inertia
from service.config.sources import add_config_arguments, from_arguments, read
from service.config.traced_effects import configured_effects
from service.inputs.input_mapper import InputMapper
from service.recordings.validation import read_validation


def add_arguments(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    show = actions.add_parser("show", help="prints the configuration in force, commented")
    add_config_arguments(show)
    add_json_argument(show)
    check = actions.add_parser("check", help="lists the errors of a file, with their lines")
    check.add_argument("file", metavar="FILE", type=Path)
    check.add_argument(
        "--user",
        metavar="USER",
        help="who will run the learner, such as incsvr: opens all files with that user's rights",
    )


def run(args: argparse.Namespace) -> int:
    if args.action == "check":
        print(_checked(args.file, args.user))
        return 0
    config = from_arguments(args)
    emit(args, config.model_dump(mode="json"), commented_yaml(config).rstrip())
    return 0


def _checked(path: Path, user: str | None) -> str:
    """One sentence on a configuration in which nothing is wrong, after everything that it names was opened."""
    config = read(path)
    check_inertia(config)
    check_files(config, path, user)
    prefixes = [each.prefix for each in config.each()]
    bus = check_bus(config.bus, prefixes)
    for each in config.each():
        if not each.inputs.own:
            InputMapper(mapping(each))
        effects = configured_effects(each)
        for recording in each.validation.values():
            read_validation(recording, each, effects)
    said = f"{path}: good; the learner serves {', '.join(prefixes)} {bus}"
    if user is None and os.geteuid() == 0 and config.bus.zenoh_file is not None:
        said += "; root can read every key: --user incsvr checks the keys as the unit's user"
    return said
