"""The whole configuration as a value: typed, bounded, with units, and what follows from it for each part of a learner.

What is wrong is said in one sentence that names where it came from. `service.config.sources` reads it.
"""

from __future__ import annotations

from collections import ChainMap, defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, Self

from pydantic import Field, ValidationError, model_validator

from incsvr.errors import BadInput
from incsvr.learning.learner import Settings as LearnerSettings
from incsvr.plant.attitude import ATTITUDE
from incsvr.plant.axes import AXES, VELOCITIES, Axis, stream_of
from incsvr.plant.body import Coupled
from incsvr.plant.mass_and_coriolis import mass_matrix
from incsvr.signals import SignalSettings
from service.config.core_yaml import quote
from service.config.sections import Archive, Bus, HealthLimits, Learner, Signals, Tracing, Vehicle
from service.inputs.settings import Axis as AxisName
from service.inputs.settings import Inputs
from service.number import decimal_comma
from service.wire import Keys
from service.wire.json_text import json_text
from service.wire.section import Name, Prefix, Section

REMOVED = {
    "vehicle.file": "`incsvr serve --vehicle FILE` learns its axes, as does a copy of its section learners",
    "also": "list every learner of the process in the section learners, each under a name",
    "inputs.thrusters.also_along": "the thrusters' positions give the efforts of all axes of `learners`",
    "learner.bins": "the criterion has 20 bins",
    "learner.near": "over several velocities the policy weighted learns, which needs none",
    "health.stuck_after": "a yaw rate that is constant for 2 s is a fault",
    "health.warn_for": "health shows a rejected sample for 10 s",
    "health.fresh_for": "a sample counts as fresh for 900 s",
    "archive.file_mb": "a file ends at 32 MB; archive.most_mb limits all files together",
    "simulation": "`incsvr simulate` has the flags --runs, --seed and --underway",
}


def unknown(name: str) -> str:
    """The sentence that refuses a name which is not, or no longer, in the configuration."""
    instead = REMOVED.get(name)
    if instead is None:
        return f"there is no {name}; `incsvr config show` lists all names"
    return f"{name} left the configuration; leave it out: {instead}"


class Config(Section):
    """Everything. `learners` holds several learners of one process: each repeats only what differs."""

    prefix: Prefix = Field(default="leng/yaw", description="prefix of the keys")
    state: Path | None = Field(default=Path("state"), description="directory of the durable state; null keeps nothing")
    history: int = Field(default=20_000, ge=1, le=10_000_000, description="published revisions kept in it")
    validation: dict[Name, Path] = Field(default={}, description="logs of any format to measure the error on, by name")
    effects: Path | None = Field(
        default=None, description="effects file written by `incsvr trace --json FILE`; null: none"
    )
    learners: dict[Name, dict[str, Any]] = Field(
        default={},
        max_length=1000,
        description="the learners of this process by name, each with the values that differ from the others'; {}: one",
    )
    bus: Bus = Bus()
    vehicle: Vehicle = Vehicle()
    signals: Signals = Signals()
    learner: Learner = Learner()
    health: HealthLimits = HealthLimits()
    tracing: Tracing = Tracing()
    archive: Archive = Archive()
    inputs: Inputs = Inputs()

    @model_validator(mode="after")
    def _traceable(self) -> Self:
        needed = 2.0 * self.learner.batch * self.signals.sample_period + self.tracing.proof
        if self.tracing.on and self.effects is not None:
            raise ValueError("tracing.live finds the effects itself; leave out either it or effects")
        if self.tracing.on and self.tracing.window < needed:
            raise ValueError(
                f"tracing.window must cover two batches and the proof, {needed:g} s; it is {self.tracing.window:g} s"
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
        return self

    @property
    def further_inputs(self) -> tuple[str, ...]:
        """The streams of the further velocities that damping is learned over."""
        return tuple(stream_of(AXES[self.vehicle.axis], name) for name in self.learner.inputs[1:])

    def signal_settings(self) -> SignalSettings:
        """The settings of the synchroniser."""
        vehicle = self.vehicle
        return SignalSettings(
            inertia=vehicle.inertia,
            rate_limit=vehicle.rate_limit,
            torque_limit=vehicle.torque_limit,
            **self.signals.model_dump()
            | {"channels": tuple(dict.fromkeys((*self.signals.channels, *self.further_inputs)))},
        )

    def learner_settings(self) -> LearnerSettings:
        """The settings of the learner."""
        axis, learner = AXES[self.vehicle.axis], self.learner
        return LearnerSettings(
            rate_range=self.vehicle.rate_range,
            own=axis.rate,
            others=self.further_inputs,
            fastest={stream_of(axis, name): value for name, value in learner.fastest.items()},
            **learner.model_dump(exclude={"inputs", "fastest"}),
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

    def hears(self, other: Config) -> tuple[str, ...]:
        """Under what name the velocity of another learner of the same vehicle comes to this one, if it is another."""
        if other.vehicle.name != self.vehicle.name or other.vehicle.axis == self.vehicle.axis:
            return ()
        return (stream_of(AXES[self.vehicle.axis], AXES[other.vehicle.axis].rate),)

    def thrust_axes(self, learners: Sequence[Config]) -> tuple[AxisName, ...]:
        """The axes of other learners whose efforts the thrusters of these inputs make, where all their places are known
        and no channel brings the effort."""
        thrusters = self.inputs.thrusters
        if thrusters is None or any(each.position is None for each in thrusters.each):
            return ()
        led = [each.vehicle.axis for each in learners if self.hears(each) and each.inputs.own]
        return tuple(axis for axis in led if AXES[axis].effort not in self.inputs.channels)

    @property
    def axis_asked(self) -> Axis:
        """The axis that a client asks about: that which is configured, else the one that the prefix ends with."""
        last = self.prefix.rpartition("/")[2]
        said = "axis" in self.vehicle.model_fields_set or last not in AXES
        return AXES[self.vehicle.axis if said else last]

    def each(self, where: Mapping[tuple[str, ...], str] = MappingProxyType({})) -> tuple[Config, ...]:
        """The configuration of every learner in this process; `where` says of the place of a value where it came from.

        Raises:
            BadInput: two of them share a name that each needs for itself.
        """
        learners = tuple(self.named(where).values())
        prefixes = [config.prefix for config in learners]
        twice = {prefix for prefix in prefixes if prefixes.count(prefix) > 1}
        if twice:
            raise BadInput(f"two learners share the prefix {min(twice)}; give each of `learners` a prefix of its own")
        files = [Keys(prefix).file_name for prefix in prefixes]
        shared = [prefix for prefix, name in zip(prefixes, files, strict=True) if files.count(name) > 1]
        if self.archive.directory is not None and shared:
            raise BadInput(
                f"the archives of {' and '.join(shared)} have the same file names; rename one of the prefixes"
            )
        return learners

    def named(self, where: Mapping[tuple[str, ...], str] = MappingProxyType({})) -> dict[str, Config]:
        """The learners by their names, each with its values in place of those of the file; "" names the only one.

        A learner without inputs of its own gets those of the first one of its vehicle, which reads each message once.
        """
        if not self.learners:
            return {"": self}
        found: dict[str, Config] = {}
        everywhere = dict(where)
        below: defaultdict[str, dict[tuple[str, ...], str]] = defaultdict(dict)
        for place, source in where.items():
            if place[0] == "learners" and len(place) > 2:
                below[place[1]][place[2:]] = source
        for name, own in self.learners.items():
            if "learners" in own:
                raise BadInput(f"learners.{name} has learners of its own; list all of them in one section")
            values = merge(self.model_dump(exclude={"learners"}, exclude_unset=True), own)
            config = _of_its_axis(values, own, ChainMap(below[name], everywhere))
            first = next((each for each in found.values() if each.hears(config)), config)
            if first is not config and "inputs" not in own:
                config = config.model_copy(update={"inputs": Inputs()})
            found[name] = config
        return found

    def of_axis(self, axis: str | None) -> Config:
        """The learner of an axis in this process, with the inputs of the first one; the first one if none is of it."""
        first, *others = self.each()
        if axis in (None, first.vehicle.axis):
            return first
        of_it = next((each for each in others if each.vehicle.axis == axis), first)
        return of_it.model_copy(update={"inputs": first.inputs})


def _of_its_axis(values: dict[str, Any], own: Mapping[str, Any], where: Mapping[tuple[str, ...], str]) -> Config:
    """The learner with these values, of which `own` are its own; without a prefix it takes that of the others, with its
    axis at the end, and with a mass matrix the inertia of its axis."""
    section = values.get("vehicle")
    vehicle: Mapping[str, Any] = section if isinstance(section, Mapping) else {}
    if vehicle.get("mass_matrix") is not None and "inertia" not in own.get("vehicle", {}):
        values = {**values, "vehicle": {name: value for name, value in vehicle.items() if name != "inertia"}}
    config = validate(values, where)
    if "prefix" in own:
        return config
    above, _, last = config.prefix.rpartition("/")
    above = above if last in AXES else config.prefix
    return config.model_copy(update={"prefix": f"{above}/{config.vehicle.axis}".lstrip("/")})


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
                f"{learner.prefix}: the {'mass' if axis.along else 'inertia'} is not configured, and the default is "
                "that of Leng; give vehicle.inertia with added mass, or vehicle.mass_matrix (`incsvr fit LOG "
                "--inertia estimate --write FILE` estimates it from open-loop runs)"
            )


def merge(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """`base` with the values of `over` in their places."""
    both = dict(base)
    for name, value in over.items():
        below = both.get(name)
        both[name] = merge(below, value) if isinstance(below, Mapping) and isinstance(value, Mapping) else value
    return both


def validate(values: Mapping[str, Any], where: Mapping[tuple[str, ...], str]) -> Config:
    """The configuration with these values; `where` says of the place of a value where it came from.

    Raises:
        BadInput: naming that, and what is allowed there.
    """
    try:
        return Config(**values)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = tuple(str(part) for part in first["loc"])
        named = quote(".".join(place))
        source = next((where[place[:end]] for end in range(len(place), 0, -1) if place[:end] in where), None)
        if first["type"] == "extra_forbidden":
            reason = unknown(named)
        else:
            reason = f"{named or 'the configuration'}: {first['msg'].removeprefix('Value error, ')}"
            if not isinstance(first["input"], Mapping):
                reason += f", not {_written(first['input'])}"
            reason += decimal_comma(str(first["input"]))
            if first["type"] == "string_type":
                reason += "; write a text in quotes"
        raise BadInput(f"{source}: {reason}" if source else reason) from None


def _written(given: Any) -> str:
    """A refused value as it is written in YAML."""
    return quote(json_text(given) if given is None or isinstance(given, bool) else repr(given))
