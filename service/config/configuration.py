"""The whole configuration as a value: typed, bounded, with units, and what follows from it for each part of a learner.

What is wrong is said in one sentence that names where it came from. `service.config.sources` reads it.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
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
from service.config.removed import unknown
from service.config.sections import Archive, Bus, HealthLimits, Learner, Signals, Tracing
from service.config.vehicle import Vehicle
from service.inputs.settings import Inputs
from service.wire import Keys
from service.wire.json_text import json_text
from service.wire.section import Name, Prefix, Section


class Config(Section):
    """Everything. `also` holds further learners of the same process: each repeats only what differs."""

    prefix: Prefix = Field(default="leng/yaw", description="prefix of the keys")
    state: Path | None = Field(default=Path("state"), description="directory of the durable state; null keeps nothing")
    history: int = Field(default=20_000, ge=1, le=10_000_000, description="published revisions kept in it")
    validation: dict[Name, Path] = Field(default={}, description="logs of any format to measure the error on, by name")
    effects: Path | None = Field(
        default=None, description="effects file written by `incsvr trace --json FILE`; null: none"
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

    def _hearing(self, learners: tuple[Config, ...]) -> Config:
        """This configuration, where samples wait for all that the body asks for and something brings: a learner of
        another axis of the vehicle in this process, or `inputs.channels`."""
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

    @property
    def axis_asked(self) -> Axis:
        """The axis that a client asks about: that which is configured, else the one that the prefix ends with."""
        last = self.prefix.rpartition("/")[2]
        said = "axis" in self.vehicle.model_fields_set or last not in AXES
        return AXES[self.vehicle.axis if said else last]

    def leads(self, other: Config) -> bool:
        """Whether both are of one vehicle file, so that channels come to the first of its learners for all of them."""
        mine, its = self.vehicle, other.vehicle
        return mine.file is not None and (mine.file, mine.name) == (its.file, its.name)

    def _led(self, other: Config) -> Config:
        """Another learner, which hears through this one what comes in the forms of others, if this one leads it."""
        return other.model_copy(update={"inputs": Inputs()}) if self.leads(other) else other

    def each(self) -> tuple[Config, ...]:
        """The configuration of every learner in this process: this one, then those of `also`."""
        base = self.model_dump(exclude={"also"})
        if self.vehicle.mass_matrix is not None or not self.vehicle.inertia_said:
            del base["vehicle"]["inertia"]  # it follows from the matrix, of each axis its own; or nobody said it
        rest = tuple(self._led(validate(merge(base, entry), {})) for entry in self.also)
        if any(config.also for config in rest):
            raise BadInput("an entry of `also` has an `also` of its own; list all learners in the first one")
        prefixes = [self.prefix, *(config.prefix for config in rest)]
        twice = {prefix for prefix in prefixes if prefixes.count(prefix) > 1}
        if twice:
            raise BadInput(
                f"two learners share the prefix {min(twice)}; give every entry of `also` a prefix of its own"
            )
        files = [Keys(prefix).file_name for prefix in prefixes]
        shared = [prefix for prefix, name in zip(prefixes, files, strict=True) if files.count(name) > 1]
        if self.archive.directory is not None and shared:
            raise BadInput(
                f"the archives of {' and '.join(shared)} have the same file names; rename one of the prefixes"
            )
        learners = (self, *rest)
        return tuple(learner._hearing(learners) for learner in learners)

    def of_axis(self, axis: str | None) -> Config:
        """The learner of an axis in this process, with the inputs of the first one; this one where none is of it."""
        if axis in (None, self.vehicle.axis):
            return self
        base = self.model_dump(exclude={"also"}, exclude_unset=True)
        if self.vehicle.mass_matrix is not None:
            base["vehicle"].pop("inertia", None)  # as in `each`
        for entry in self.also:
            if entry.get("vehicle", {}).get("axis") == axis:
                return validate(merge(base, entry) | {"inputs": self.inputs}, {})
        return self


def check_first_axis(config: Config) -> None:
    """Refuses a vehicle file whose first learner, through which all hear the forms of others, is not that of yaw.

    Raises:
        BadInput: with the cure.
    """
    axes = {each.vehicle.axis for each in config.each() if config.leads(each)}
    if "yaw" in axes and config.vehicle.axis != "yaw" and not config.inputs.own:
        raise BadInput(
            f"prefix: with inputs, the first learner of {config.vehicle.file} is that of yaw, not "
            f"{config.vehicle.axis}; let the prefix end with yaw"
        )


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
            if first["type"] == "string_type":
                reason += "; write a text in quotes"
        raise BadInput(f"{source}: {reason}" if source else reason) from None


def _written(given: Any) -> str:
    """A refused value as it is written in YAML."""
    return quote(json_text(given) if given is None or isinstance(given, bool) else repr(given))
