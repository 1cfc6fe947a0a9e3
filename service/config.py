"""The whole configuration: typed, bounded, with units; a YAML file, then INCSVR_… variables, then flags.

A nested value is named with two underscores in a variable, INCSVR_LEARNER__POLICY=paper, and with a dot in a flag,
`--set learner.policy=paper`. What is wrong is said in one sentence that names the line of the file, the variable or the
flag it came from.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

import yaml
from pydantic import Field, ValidationError, model_validator

from incsvr.errors import BadInput
from incsvr.learning.learner import Settings as LearnerSettings
from incsvr.plant.attitude import ATTITUDE
from incsvr.plant.axes import AXES, VELOCITIES, stream_of
from incsvr.plant.body import Coupled
from incsvr.plant.inertia import mass_matrix
from incsvr.signals import SignalSettings
from service.inputs.presets.defaults import defaults
from service.inputs.settings import Inputs
from service.sections import (
    Archive,
    Bus,
    HealthLimits,
    Learner,
    Name,
    Prefix,
    Section,
    Signals,
    Simulation,
    Tracing,
    Vehicle,
)


class Config(Section):
    """Everything. `also` holds further learners of the same process: each repeats only what differs."""

    prefix: Prefix = Field(default="leng/yaw", description="the keys begin with it")
    state: Path | None = Field(default=Path("state"), description="directory of the durable state; null keeps nothing")
    history: int = Field(default=20_000, ge=1, le=10_000_000, description="published revisions kept in it")
    validation: dict[Name, Path] = Field(default={}, description="recordings to measure the error on, by name")
    effects: Path | None = Field(
        default=None, description="what the model lacks, as `incsvr trace --json FILE` wrote it; null for nothing"
    )
    also: tuple[dict[str, Any], ...] = Field(
        default=(), max_length=1000, description="further learners in this process"
    )
    bus: Bus = Bus()
    vehicle: Vehicle = Vehicle()
    signals: Signals = Signals()
    learner: Learner = Learner()
    health: HealthLimits = HealthLimits()
    tracing: Tracing = Tracing()
    archive: Archive = Archive()
    simulation: Simulation = Simulation()
    inputs: Inputs = Inputs()

    @model_validator(mode="after")
    def _traceable(self) -> Self:
        needed = 2.0 * self.learner.batch * self.signals.sample_period + self.tracing.proof
        if self.tracing.on and self.effects is not None:
            raise ValueError("tracing.live finds the effects itself; leave out either it or effects")
        if self.tracing.on and self.tracing.window < needed:
            raise ValueError(
                f"tracing.window must hold two batches and the proof, which take {needed:g} s; it is "
                f"{self.tracing.window:g} s"
            )
        return self

    @model_validator(mode="after")
    def _learnable(self) -> Self:
        inputs, own = self.learner.inputs, AXES[self.vehicle.axis].rate
        if inputs == ("yaw_rate",):  # the own velocity alone, whatever the axis
            return self
        if inputs[0] != own:
            raise ValueError(f"learner.inputs begins with the axis's own velocity, {own}; it is {', '.join(inputs)}")
        if len(set(inputs)) < len(inputs):
            raise ValueError(f"learner.inputs names a velocity twice: {', '.join(inputs)}")
        foreign = [name for name in inputs if name not in VELOCITIES]
        if foreign:
            raise ValueError(f"learner.inputs: {foreign[0]} is no velocity; they are {', '.join(VELOCITIES)}")
        if inputs[1:] and self.tracing.on:
            raise ValueError("tracing.live works over one velocity; set it to off, or learner.inputs to one")
        return self

    @property
    def further_inputs(self) -> tuple[str, ...]:
        """The streams of the further velocities that damping is learned over."""
        return tuple(stream_of(AXES[self.vehicle.axis], name) for name in self.learner.inputs[1:])

    def signal_settings(self) -> SignalSettings:
        """What the synchroniser is told."""
        vehicle = self.vehicle
        return SignalSettings(
            inertia=vehicle.inertia,
            rate_limit=vehicle.rate_limit,
            torque_limit=vehicle.torque_limit,
            **self.signals.model_dump()
            | {"channels": tuple(dict.fromkeys((*self.signals.channels, *self.further_inputs)))},
        )

    def learner_settings(self) -> LearnerSettings:
        """What the learner is told."""
        axis, learner = AXES[self.vehicle.axis], self.learner
        return LearnerSettings(
            rate_range=self.vehicle.rate_range,
            own=axis.rate,
            others=self.further_inputs,
            fastest={stream_of(axis, name): value for name, value in learner.fastest.items()},
            near={stream_of(axis, name): value for name, value in learner.near.items()},
            **learner.model_dump(exclude={"inputs", "fastest", "near"}),
        )

    def coupled(self) -> Coupled | None:
        """The axis in its body, with the velocities and angles that samples wait for; None takes it by itself."""
        known = {*self.signals.channels, *self.further_inputs}
        axis = AXES[self.vehicle.axis]
        heard = tuple(name for name in VELOCITIES if stream_of(axis, name) in known)
        return self._in_its_body((*heard, *(name for name in ATTITUDE if name in known)))

    def _in_its_body(self, recorded: tuple[str, ...]) -> Coupled | None:
        vehicle = self.vehicle
        if vehicle.mass_matrix is None and vehicle.weight is None:
            return None
        axis = AXES[vehicle.axis]
        alone = tuple(vehicle.inertia if name == axis.name else 0.0 for name in AXES)
        return Coupled(axis, mass_matrix(vehicle.mass_matrix or alone), recorded, vehicle.restoring)

    def _hearing(self, learners: tuple[Config, ...]) -> Config:
        """The same, where samples wait for all that the body asks for and something brings: a learner of another axis
        of the vehicle in this process, or `inputs.channels`."""
        coupled = self._in_its_body((*VELOCITIES, *ATTITUDE))
        if coupled is None:
            return self
        brought = {*self.inputs.channels, *(name for other in learners for name in self.hears(other))}
        channels = dict.fromkeys((*self.signals.channels, *(name for name in coupled.streams if name in brought)))
        channels.pop(coupled.axis.rate, None)  # its own, which the file may name for the learner of another axis
        return self.model_copy(update={"signals": self.signals.model_copy(update={"channels": tuple(channels)})})

    def hears(self, other: Config) -> tuple[str, ...]:
        """Under what name the velocity of another learner of the same vehicle comes to this one, if it is another."""
        if other.vehicle.name != self.vehicle.name or other.vehicle.axis == self.vehicle.axis:
            return ()
        return (stream_of(AXES[self.vehicle.axis], AXES[other.vehicle.axis].rate),)

    def each(self) -> tuple[Config, ...]:
        """The configuration of every learner in this process: this one, then those of `also`."""
        base = self.model_dump(exclude={"also"})
        if self.vehicle.mass_matrix is not None or not self.vehicle.inertia_said:
            del base["vehicle"]["inertia"]  # it follows from the matrix, of each axis its own; or nobody said it
        rest = tuple(_validated(_merged(base, entry), {}) for entry in self.also)
        prefixes = [self.prefix, *(config.prefix for config in rest)]
        twice = {prefix for prefix in prefixes if prefixes.count(prefix) > 1}
        if twice:
            raise BadInput(
                f"two learners share the prefix {min(twice)}; give every entry of `also` a prefix of its own"
            )
        learners = (self, *rest)
        return tuple(learner._hearing(learners) for learner in learners)


def check_inertia(config: Config) -> None:
    """Refuses to learn a vehicle by Leng's inertia because nobody said its own.

    Raises:
        BadInput: naming the learner and how to get one.
    """
    for learner in config.each():
        vehicle, axis = learner.vehicle, AXES[learner.vehicle.axis]
        lengs = vehicle.name == Vehicle().name and vehicle.axis == Vehicle().axis and learner.inputs.own
        if not vehicle.inertia_said and not lengs:
            raise BadInput(
                f"{learner.prefix}: the {'mass' if axis.along else 'inertia'} is not known, and that of Leng is no "
                "other vehicle's; give vehicle.inertia with added mass, or vehicle.mass_matrix (`incsvr fit LOG "
                "--inertia estimate --write FILE` writes what open-loop runs tell)"
            )


def add_config_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the flags that every command which speaks on the bus understands."""
    parser.add_argument("--config", metavar="FILE", type=Path, help="the configuration; without it the defaults (Leng)")
    parser.add_argument("--connect", metavar="ENDPOINT", help="where the bus is, such as tcp/127.0.0.1:7447")
    parser.add_argument("--prefix", metavar="KEYS", help="the keys begin with it, such as leng/yaw")
    parser.add_argument(
        "--set", metavar="NAME=VALUE", action="append", default=[], help="one value, such as learner.policy=paper"
    )


def from_arguments(args: argparse.Namespace) -> Config:
    """The configuration in force, given the flags of `add_config_arguments`."""
    flags: dict[str, Any] = {}
    origin: dict[tuple[str, ...], str] = {}
    given = [("prefix", args.prefix, "--prefix"), ("bus.connect", args.connect, "--connect")]
    for text in args.set:
        name, equals, value = text.partition("=")
        if not equals:
            raise BadInput(f"--set {text}: write NAME=VALUE, such as learner.policy=paper")
        given.append((name, yaml.safe_load(value), f"--set {name}"))
    for name, value, flag in given:
        if value is not None or flag.startswith("--set"):
            path = tuple(name.split("."))
            origin[path] = flag
            flags = _merged(flags, _nested(path, value))
    return read(args.config, flags, origin)


def read(
    path: Path | None = None,
    flags: Mapping[str, Any] | None = None,
    origin: Mapping[tuple[str, ...], str] | None = None,
) -> Config:
    """The configuration in force: the file, then INCSVR_… variables, then flags.

    Raises:
        BadInput: naming the line, the variable or the flag, and what is allowed there.
    """
    values: dict[str, Any] = {}
    where: dict[tuple[str, ...], str] = {}
    if path is not None:
        values, lines = _yaml(path)
        where |= {place: f"{path}, line {line}" for place, line in lines.items()}
    variables = _variables()
    for place in _places(variables):
        where[place] = "the variable INCSVR_" + "__".join(place).upper()
    values = _merged(_merged(values, variables), flags or {})
    values = _merged(defaults(values), values)
    where |= origin or {}
    config = _validated(values, where)
    for index, entry in enumerate(config.also):
        below = {place[2:]: source for place, source in where.items() if place[:2] == ("also", str(index))}
        _validated(_merged(values | {"also": ()}, entry), where | below)
    config.each()
    return config


def _yaml(path: Path) -> tuple[dict[str, Any], dict[tuple[str, ...], int]]:
    """The values of a YAML file, and the line of each."""
    try:
        text = path.read_text(encoding="utf-8")
        node = yaml.compose(text, yaml.SafeLoader)
        values = yaml.safe_load(text)
    except FileNotFoundError:
        raise BadInput(f"{path}: there is no such file; `incsvr config show` prints one to begin with") from None
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(f"{path}: cannot be read as text ({error})") from None
    except yaml.MarkedYAMLError as error:
        line = (error.problem_mark or error.context_mark or yaml.Mark("", 0, 0, 0, None, 0)).line + 1
        raise BadInput(f"{path}, line {line}: this is no YAML: {error.problem}") from None
    except yaml.YAMLError as error:
        raise BadInput(f"{path}: this is no YAML: {error}") from None
    if values is None:
        return {}, {}
    if not isinstance(values, dict):
        raise BadInput(f"{path}, line 1: the configuration is a list of `name: value` lines")
    return values, dict(_lines(node, ()))


def _lines(node: yaml.Node | None, place: tuple[str, ...]) -> list[tuple[tuple[str, ...], int]]:
    found: list[tuple[tuple[str, ...], int]] = []
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            here = (*place, str(key.value))
            found += [(here, key.start_mark.line + 1), *_lines(value, here)]
    elif isinstance(node, yaml.SequenceNode):
        for index, value in enumerate(node.value):
            here = (*place, str(index))
            found += [(here, value.start_mark.line + 1), *_lines(value, here)]
    return found


def _variables() -> dict[str, Any]:
    """What the INCSVR_… variables say, nested."""
    named = sorted(name for name in os.environ if name.startswith("INCSVR_"))
    for name in named:
        top = name.removeprefix("INCSVR_").partition("__")[0].lower()
        if top not in Config.model_fields:
            raise BadInput(f"the variable {name}: there is no {top}; `incsvr config show` lists all names")
    if not named:
        return {}
    # Loaded where it is needed alone: it brings 10 MB and a quarter of a second with it.
    from pydantic_settings import BaseSettings, EnvSettingsSource, SettingsConfigDict, SettingsError

    class Variables(Config, BaseSettings):
        model_config = SettingsConfigDict(env_prefix="INCSVR_", env_nested_delimiter="__")

    try:
        return EnvSettingsSource(Variables)()
    except SettingsError as error:
        raise BadInput(f"an INCSVR_ variable is not understood: {error}; lists are written as JSON") from None


def _nested(path: tuple[str, ...], value: Any) -> dict[str, Any]:
    for name in reversed(path):
        value = {name: value}
    return dict(value)


def _places(values: Mapping[str, Any], place: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    found = []
    for name, value in values.items():
        found += _places(value, (*place, name)) if isinstance(value, Mapping) else [(*place, name)]
    return found


def _merged(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """`base` with the values of `over` in their places."""
    merged = dict(base)
    for name, value in over.items():
        below = merged.get(name)
        merged[name] = _merged(below, value) if isinstance(below, Mapping) and isinstance(value, Mapping) else value
    return merged


def _validated(values: Mapping[str, Any], where: Mapping[tuple[str, ...], str]) -> Config:
    try:
        return Config(**values)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = tuple(str(part) for part in first["loc"])
        named = ".".join(place)
        source = next((where[place[:end]] for end in range(len(place), 0, -1) if place[:end] in where), None)
        if first["type"] == "extra_forbidden":
            reason = f"there is no {named}; `incsvr config show` lists all names"
        else:
            reason = f"{named or 'the configuration'}: {first['msg'].removeprefix('Value error, ')}"
            if not isinstance(first["input"], Mapping):
                reason += f", not {first['input']!r}"
        raise BadInput(f"{source}: {reason}" if source else reason) from None
