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
from typing import Annotated, Any, Literal, Self

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator

from incsvr.errors import BadInput
from incsvr.learner import Settings as LearnerSettings
from incsvr.signals import MAX_CHANNELS, SignalSettings

Endpoint = Annotated[str, Field(pattern=r"^(tcp|tls|quic|ws|unixsock-stream)/\S+$")]
Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9_.-]+$", max_length=64)]
Prefix = Annotated[str, Field(pattern=r"^[A-Za-z0-9_.-]+(/[A-Za-z0-9_.-]+)*$", max_length=128)]
Seconds = Annotated[float, Field(gt=0.0, le=1e6)]


class Section(BaseModel):
    """A part of the configuration: unknown names are refused, because they are misspelt ones."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Bus(Section):
    """Where the learner is met."""

    listen: Endpoint = Field(
        default="tcp/127.0.0.1:7447", description="endpoint at which the learner listens; loopback"
    )
    connect: Endpoint | None = Field(
        default=None, description="endpoint of an existing router; the learner is its client then"
    )
    zenoh_file: Path | None = Field(default=None, description="a Zenoh JSON5 file (TLS, access control), used as it is")

    @field_validator("listen")
    @classmethod
    def _not_everywhere(cls, endpoint: str) -> str:
        if any(everywhere in endpoint for everywhere in ("/0.0.0.0:", "/[::]:", "/:")):
            raise ValueError("this listens on all interfaces; name one address, or give a zenoh_file with TLS")
        return endpoint


class Vehicle(Section):
    """Whose damping it is."""

    name: Name = Field(default="leng", description="the vehicle; a state of another one is refused")
    inertia: float = Field(default=350.0, gt=0.0, le=1e7, description="dry and added mass about yaw [kg m²]")
    rate_range: tuple[float, float] = Field(
        default=(-0.25, 0.25), description="lowest and highest yaw rate it reaches [rad/s]"
    )
    rate_limit: float = Field(default=1.0, gt=0.0, le=50.0, description="a yaw rate beyond is no measurement [rad/s]")
    torque_limit: float = Field(default=500.0, gt=0.0, le=1e7, description="a torque beyond is no measurement [N m]")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        low, high = self.rate_range
        if not -self.rate_limit <= low < high <= self.rate_limit:
            raise ValueError("rate_range needs its lower end first, and both within ± rate_limit")
        return self


class Signals(Section):
    """How two streams become samples."""

    sample_period: float = Field(default=0.6, gt=0.0, le=60.0, description="between two samples [s]")
    smoothing: float = Field(
        default=0.12, gt=0.0, le=10.0, description="standard deviation of the Gaussian low-pass [s]"
    )
    lateness: float = Field(default=0.2, ge=0.0, le=10.0, description="how far out of order a message may come [s]")
    gap: float = Field(
        default=0.2, gt=0.0, lt=5.0, description="longest pause that is bridged [s], at most 2 smoothing"
    )
    channels: tuple[Name, ...] = Field(
        default=(), max_length=MAX_CHANNELS, description="channels that samples wait for"
    )

    @model_validator(mode="after")
    def _bridged(self) -> Self:
        if self.gap > 2.0 * self.smoothing:
            raise ValueError("gap is longer than twice the smoothing: the filter would bridge what it has not seen")
        return self


class Learner(Section):
    """How it learns; γ, C, ε as tuned in Section IV-B of the paper, the rest from III-C."""

    policy: Literal["paper", "weighted"] = Field(default=LearnerSettings().policy, description="which samples are kept")
    solver: Literal["exact", "passes"] = Field(default="exact", description="exact, or Eq. 8's passes")
    gamma: float = Field(default=10.0, gt=0.0, le=1e6, description="kernel width [(rad/s)⁻²]")
    C: float = Field(default=1000.0, gt=0.0, le=1e9, description="bound of a vector's weight [N m]")
    epsilon: float = Field(default=0.1, ge=0.0, le=1e6, description="half height of the tube [N m]")
    capacity: int = Field(default=60, ge=2, le=60, description="support vectors served at most")
    batch: int = Field(default=50, ge=2, le=1000, description="samples of one iteration")
    near_rate: float = Field(default=0.01, gt=0.0, le=10.0, description="a of the inclusion criterion [rad/s]")
    near_damping: float = Field(default=5.0, gt=0.0, le=1e6, description="b of the inclusion criterion [N m]")
    bins: int = Field(default=20, ge=1, le=1000, description="bins of the forgetting criterion")


class HealthLimits(Section):
    """When health warns."""

    stale_after: Seconds = Field(default=2.0, description="a stream silent for longer makes it STALE [s], wall time")
    stuck_after: Seconds = Field(default=2.0, description="a yaw rate that stands still for longer is a fault [s]")
    warn_for: Seconds = Field(default=10.0, description="how long a rejected sample is remembered [s], wall time")
    fresh_for: Seconds = Field(
        default=900.0, description="how long a sample counts as fresh in `learned` [s], vehicle's time"
    )


class Tracing(Section):
    """Whether the learner traces what its model lacks by itself, in a process beside it."""

    live: bool = Field(default=False, description="traces where the residual is no longer white")
    window: Seconds = Field(default=900.0, description="the recent data that are kept for it [s], vehicle's time")
    proof: Seconds = Field(default=300.0, description="fresh data that effects must prove themselves on [s]")

    @model_validator(mode="after")
    def _learned_before(self) -> Self:
        if self.proof > 0.5 * self.window:
            raise ValueError("proof is more than half the window: too little is left to learn from before it")
        return self


class Simulation(Section):
    """What `incsvr simulate` plays: Leng's experiment and the faults of its sensors."""

    seed: int = Field(default=1, ge=0, le=2**32 - 1, description="the same seed plays the same")
    runs: tuple[Literal["V1", "T1", "V2", "T2"], ...] = Field(
        default=("T1", "T2"), min_length=1, description="in this order"
    )
    drop_outs: float = Field(default=0.0, ge=0.0, le=60.0, description="drop-outs of a stream per minute")
    drop_out_length: Seconds = Field(default=1.0, description="mean length of a drop-out [s]")
    jitter: float = Field(default=0.0, ge=0.0, le=1.0, description="messages come out of order by up to this [s]")
    duplicates: float = Field(default=0.0, ge=0.0, le=0.5, description="part of the messages that come twice")


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
    simulation: Simulation = Simulation()

    @model_validator(mode="after")
    def _traceable(self) -> Self:
        needed = 2.0 * self.learner.batch * self.signals.sample_period + self.tracing.proof
        if self.tracing.live and self.effects is not None:
            raise ValueError("tracing.live finds the effects itself; leave out either it or effects")
        if self.tracing.live and self.tracing.window < needed:
            raise ValueError(
                f"tracing.window must hold two batches and the proof, which take {needed:g} s; it is "
                f"{self.tracing.window:g} s"
            )
        return self

    def signal_settings(self) -> SignalSettings:
        """What the synchroniser is told."""
        vehicle = self.vehicle
        return SignalSettings(
            inertia=vehicle.inertia,
            rate_limit=vehicle.rate_limit,
            torque_limit=vehicle.torque_limit,
            **self.signals.model_dump(),
        )

    def learner_settings(self) -> LearnerSettings:
        """What the learner is told."""
        return LearnerSettings(rate_range=self.vehicle.rate_range, **self.learner.model_dump())

    def each(self) -> tuple[Config, ...]:
        """The configuration of every learner in this process: this one, then those of `also`."""
        base = self.model_dump(exclude={"also"})
        rest = tuple(_validated(_merged(base, entry), {}) for entry in self.also)
        prefixes = [self.prefix, *(config.prefix for config in rest)]
        twice = {prefix for prefix in prefixes if prefixes.count(prefix) > 1}
        if twice:
            raise BadInput(
                f"two learners share the prefix {min(twice)}; give every entry of `also` a prefix of its own"
            )
        return (self, *rest)


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
