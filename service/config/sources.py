"""The sources of the configuration: a YAML file, then INCSVR_… variables, then flags.

A nested value is named with two underscores in a variable, INCSVR_LEARNER__POLICY=paper, and with a dot in a flag,
`--set learner.policy=paper`.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from incsvr.errors import BadInput
from service.config.configuration import Config, merge, unknown, validate
from service.config.core_yaml import MAX_CHARACTERS, Document, parse
from service.config.vehicle_file import learners_in
from service.inputs.presets import ON_BUS

ROUTER = "tcp/127.0.0.1:7447"
"""The endpoint at which the router of BlueOS, of rmw_zenoh and of a Keelson vessel listens; the learner is one more
client of it."""
_PLACES = ("listen", "connect", "zenoh_file")
_BLUEROV: dict[str, Any] = {
    # A six-thruster ROV: I from a published identification, the rest as `incsvr fit` scaled it to runs of that vehicle
    # (deploy/bluerov.yaml); the limits leave room for four T200 at 20 V, which turn it with 39 N m.
    "vehicle": {
        "name": "bluerov",
        "inertia": 1.125,
        "rate_range": (-1.7, 1.7),
        "rate_limit": 6.0,
        "torque_limit": 40.0,
    },
    "signals": {"sample_period": 0.4, "smoothing": 0.2},
    "learner": {
        "policy": "weighted",
        "gamma": 0.215,
        "C": 61.2,
        "epsilon": 0.00612,
        "near_rate": 0.0682,
        "near_damping": 0.306,
    },
}


VARIABLES = "INCSVR_"
"""The begin of the names of variables."""


def defaults(values: Mapping[str, Any]) -> dict[str, Any]:
    """The values of a configuration's preset that the configuration does not set itself."""
    inputs = values.get("inputs")
    preset = inputs.get("preset") if isinstance(inputs, Mapping) else None
    found = dict(_BLUEROV) if preset == "blueos" else {}
    bus = values.get("bus")
    if preset in ON_BUS and not (isinstance(bus, Mapping) and any(bus.get(name) for name in _PLACES)):
        found["bus"] = {"connect": ROUTER}
    vehicle = values.get("vehicle")
    if isinstance(inputs, Mapping) and isinstance(inputs.get("thrusters"), Mapping) and isinstance(vehicle, Mapping):
        found["inputs"] = {"thrusters": {"axis": vehicle.get("axis", "yaw")}}
    return found


def add_config_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the flags that every command which speaks on the bus understands."""
    parser.add_argument(
        "--config", metavar="FILE", type=Path, help="configuration file; without it the defaults (Leng)"
    )
    parser.add_argument("--connect", metavar="ENDPOINT", help="endpoint of the bus, such as tcp/127.0.0.1:7447")
    parser.add_argument("--prefix", metavar="KEYS", help="prefix of the keys, such as leng/yaw")
    add_set_argument(parser, "one value, such as learner.policy=paper")


def add_set_argument(parser: argparse.ArgumentParser, what: str) -> None:
    """Adds `--set`."""
    parser.add_argument("--set", metavar="NAME=VALUE", action="append", default=[], help=what)


def add_client_arguments(parser: argparse.ArgumentParser, wait_s: float = 5.0, whom: str = "") -> None:
    """Adds `--wait` and where a learner is met; `whom` is who is waited for, in the words of the help."""
    parser.add_argument("--wait", type=float, default=wait_s, help=f"how long to try{whom} [s] (default {wait_s:g})")
    add_config_arguments(parser)


def from_arguments(args: argparse.Namespace, vehicle: Path | None = None) -> Config:
    """The configuration in force, given the flags of `add_config_arguments`, and a vehicle file."""
    given = [("prefix", args.prefix, "--prefix"), ("bus.connect", args.connect, "--connect")]
    return read(args.config, *set_values(args.set, [each for each in given if each[1] is not None]), vehicle)


def set_values(
    texts: Sequence[str], further: Sequence[tuple[str, Any, str]] = ()
) -> tuple[dict[str, Any], dict[tuple[str, ...], str]]:
    """The values of `--set`, nested, and the flag that each came from.

    Args:
        texts: as they were given, NAME=VALUE.
        further: name, value and flag of others.

    Raises:
        BadInput: one is no NAME=VALUE, or is given twice.
    """
    flags: dict[str, Any] = {}
    origin: dict[tuple[str, ...], str] = {}
    given = list(further)
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals:
            raise BadInput(f"--set {text}: write NAME=VALUE, such as learner.policy=paper")
        given.append((name, parse(value, f"--set {name}").value, f"--set {name}"))
    for name, value, flag in given:
        path = tuple(name.split("."))
        if path in origin:
            raise BadInput(f"{flag}: {name} is given twice; keep one of them")
        origin[path] = flag
        flags = merge(flags, _nested(path, value))
    return flags, origin


def read(
    path: Path | None = None,
    flags: Mapping[str, Any] | None = None,
    origin: Mapping[tuple[str, ...], str] | None = None,
    vehicle: Path | None = None,
) -> Config:
    """The configuration in force: the learners of a vehicle file, the file, then INCSVR_… variables, then flags.

    Raises:
        BadInput: naming the line, the variable or the flag, and what is allowed there.
    """
    values: dict[str, Any] = {}
    where: dict[tuple[str, ...], str] = {}
    if path is not None:
        values, lines = _from_file(path)
        where |= {place: f"{path}, line {line}" for place, line in lines.items()}
    variables = _variables()
    for place in _places(variables):
        where[place] = f"the variable {VARIABLES}{'__'.join(place).upper()}"
    values = merge(merge(values, variables), flags or {})
    if vehicle is not None:
        values = merge({"learners": learners_in(vehicle)}, values)
    where |= origin or {}
    config = validate(merge(defaults(values), values), where)
    first = config.each(where)[0]
    return config if "prefix" in values else config.model_copy(update={"prefix": first.prefix})


def sections(path: Path) -> frozenset[str]:
    """The sections that a file holds, whatever they say.

    Raises:
        BadInput: it cannot be read.
    """
    return frozenset(_from_file(path).value)


def _from_file(path: Path) -> Document:
    """The values of a YAML file, and the line of each."""
    try:
        with path.open(encoding="utf-8") as file:
            text = file.read(MAX_CHARACTERS + 1)
    except FileNotFoundError:
        raise BadInput(f"{path}: there is no such file; `incsvr config show` prints one to begin with") from None
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(f"{path}: cannot be read as text ({error})") from None
    found = parse(text, str(path))
    if found.value is None:
        return Document({}, {})
    if not isinstance(found.value, dict):
        raise BadInput(f"{path}, line 1: the configuration is a list of `name: value` lines")
    return found


def _variables() -> dict[str, Any]:
    """The values of the INCSVR_… variables, nested, each read as in the file."""
    found: dict[str, Any] = {}
    for name in sorted(each for each in os.environ if each.startswith(VARIABLES)):
        place = _place(name.removeprefix(VARIABLES).lower().split("__"))
        if place[0] not in Config.model_fields:
            raise BadInput(f"the variable {name}: {unknown(place[0])}")
        found = merge(found, _nested(place, parse(os.environ[name], f"the variable {name}").value))
    return found


def _place(names: Sequence[str]) -> tuple[str, ...]:
    """The place of a value whose names are given in small letters, such as c for C of the learner."""
    fields: Mapping[str, Any] = Config.model_fields
    found = []
    for name in names:
        found.append(next((each for each in fields if each.lower() == name), name))
        fields = getattr(getattr(fields.get(found[-1]), "annotation", None), "model_fields", {})
    return tuple(found)


def _nested(path: tuple[str, ...], value: Any) -> dict[str, Any]:
    for name in reversed(path):
        value = {name: value}
    return dict(value)


def _places(values: Mapping[str, Any], place: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    found = []
    for name, value in values.items():
        found += _places(value, (*place, name)) if isinstance(value, Mapping) else [(*place, name)]
    return found
