"""The mapping from what is on a bus or in a log to what is learned, as people write it in config.yaml."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from math import hypot
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, TypedDict

import numpy as np
from pydantic import Field, field_validator, model_validator

from incsvr.numerics import Array
from service.inputs.presets import NAMES, ON_BUS
from service.inputs.table import StampUnit
from service.inputs.units import FACTORS, unit
from service.wire.section import Name, Section, shaped

Sign = Literal[1, -1]
Axis = Literal["surge", "sway", "heave", "roll", "pitch", "yaw"]
Vector = tuple[float, float, float]
if TYPE_CHECKING:
    PresetName = str
else:
    PresetName = Literal[NAMES]
Form = Annotated[
    str,
    shaped(
        r"json|keelson|incsvr|cdr:[A-Za-z0-9_]+/msg/[A-Za-z0-9_]+",
        "the form is json, keelson, incsvr, or cdr: and a type of ROS 2, such as cdr:sensor_msgs/msg/Imu",
    ),
]


ARRIVAL = "arrival"
"""The word in place of the path of a stamp by which the time of arrival counts, whatever stamps a message bears."""
STAMP_DESCRIPTION = "path of the stamp in a message, or arrival; empty: the form's own, or else the time of arrival"


class StampedBy(TypedDict, total=False):
    """The clock of a topic, as its sources and thrusters take it."""

    stamp: str
    stamp_unit: StampUnit


class Source(Section):
    """The source of one quantity: the yaw rate, and likewise torque, channels, measured_voltage and turned_by."""

    topic: str = Field(description="topic of a log, key expression on the bus")
    field: str = Field(default="", description="path of the number in a message, such as angular_velocity.z or data[2]")
    unit: str = Field(default="", description="its unit, such as deg/s; empty where it is SI")
    sign: Sign = Field(default=1, description="-1 if it is positive in the other direction")
    scale: float = Field(default=1.0, description="further factor")
    stamp: str = Field(default="", description=STAMP_DESCRIPTION)
    stamp_unit: StampUnit = Field(default="s", description="unit of the stamp, since boot or since 1970")
    form: Form = Field(default="json", description="of a message on the bus: json, keelson, incsvr, cdr:<type>")

    @field_validator("unit")
    @classmethod
    def _check_unit(cls, spelt: str) -> str:
        found = unit(spelt)
        if found not in FACTORS:
            raise ValueError(f"there is no unit {spelt!r}; known are {', '.join(name for name in FACTORS if name)}")
        return found

    @property
    def factor(self) -> float:
        """SI over the number in the message."""
        return self.sign * self.scale * FACTORS[self.unit]


class Armed(Section):
    """Whether the autopilot lets the thrusters turn."""

    topic: str = Field(description="topic of a log, key expression on the bus")
    field: str = Field(description="path of the number in a message")
    bit: int | None = Field(default=None, description="armed where this bit of it is set, such as 128")
    equals: float | None = Field(default=None, description="armed where it has this value; else where it is not zero")
    disarmed: float | None = Field(default=None, description="with equals: not armed where it has this value alone")
    events: bool = Field(
        default=False, description="the state is sent only when it changes: not armed before the first"
    )
    stamp: str = Field(default="", description=STAMP_DESCRIPTION)
    stamp_unit: StampUnit = Field(default="s", description="unit of the stamp, since boot or since 1970")
    form: Form = Field(default="json", description="of a message on the bus: json, keelson, incsvr, cdr:<type>")


class Thruster(Section):
    """One thruster: its command and its share of the moment."""

    field: str = Field(default="", description="path of its command in a message, such as servo1_raw")
    topic: str = Field(default="", description="topic of its command, if not that of the others")
    direction: Sign = Field(default=1, description="-1 where more command is less thrust")
    arm: float | None = Field(default=None, description="lever arm: moment about the axis per thrust [m], signed")
    position: Vector | None = Field(
        default=None,
        description="ahead, to starboard, down [m]; ahead, to port, up if the yaw rate is positive to port (ROS)",
    )
    pushes: Vector | None = Field(
        default=None,
        description="direction in which it pushes the vehicle, in the same axes; its length does not count",
    )
    turned_by: Source | None = Field(
        default=None, description="an angle about the vertical axis that turns this direction: of an azimuth, a rudder"
    )

    @model_validator(mode="after")
    def _check_place(self) -> Self:
        if (self.arm is None) == (self.position is None or self.pushes is None):
            raise ValueError("give either its arm [m], or position [m] and the direction in which it pushes")
        return self

    @model_validator(mode="after")
    def _check_turning(self) -> Self:
        if self.turned_by is not None and self.pushes is None:
            raise ValueError("what is turned by an angle needs its position [m] and the direction in which it pushes")
        return self

    def share(self, axis: Axis, angle: Array) -> Array:
        """Moment [m], or force, along the axis by its thrust; its direction turned by the angle (n,) [rad]."""
        if self.position is None or self.pushes is None:
            return np.full(angle.size, float(self.arm or 0.0))
        (x, y, z), (fx, fy, fz) = self.position, np.array(self.pushes) / max(hypot(*self.pushes), 1e-12)
        fx, fy = fx * np.cos(angle) - fy * np.sin(angle), fx * np.sin(angle) + fy * np.cos(angle)
        along = {"surge": fx, "sway": fy, "heave": np.full(angle.size, fz)}
        about = {"roll": y * fz - z * fy, "pitch": z * fx - x * fz, "yaw": x * fy - y * fx}
        return np.asarray({**along, **about}[axis])


@dataclass(frozen=True, slots=True)
class Place:
    """The source of an input, as a configuration names it.

    Attributes:
        name: of what it is in the section, such as `channels.depth` or `thrusters.each.0`.
        topic: topic of a log, key expression on the bus.
        form: of a message on the bus.
        field, stamp: paths of the number and of the stamp in a message.
        stamp_unit: of the stamp.
    """

    name: str
    topic: str
    form: str
    field: str
    stamp: str
    stamp_unit: StampUnit

    @staticmethod
    def of(name: str, source: Source | Armed) -> Place:
        """The place of a source."""
        return Place(name, source.topic, source.form, source.field, source.stamp, source.stamp_unit)


class Thrusters(Section):
    """The thrusters, whose commands give the torque."""

    topic: str = Field(default="", description="topic of a log, key expression on the bus")
    command: Literal["pwm", "fraction", "rpm", "rad/s", "N"] = Field(description="what a command is; pwm in µs")
    each: tuple[Thruster, ...] = Field(min_length=1, description="the thrusters that turn the vehicle")
    curve: Literal["t200", "linear", "quadratic"] | Path = Field(
        default="t200",
        description="static thrust: t200, linear, quadratic (the default of rpm and rad/s), or a file of command and "
        "newtons",
    )
    full: float = Field(
        default=1.0, gt=0.0, description="thrust at full command [N]; of rpm and rad/s K₁ of K₁ω|ω| [N s²/rad²]"
    )
    inflow: float = Field(default=0.0, description="K₂ of K₂v|ω| [N s²/(m rad)], with v the channel surge")
    voltage: float | None = Field(
        default=None, ge=6.0, le=26.0, description="voltage of the battery, where none is measured"
    )
    measured_voltage: Source | None = Field(default=None, description="source of the battery's voltage")
    axis: Axis = Field(default="yaw", description="axis along or about which they push; default: the learned one")
    scale: float = Field(default=1.0, description="further factor of the torque")
    stamp: str = Field(default="", description=STAMP_DESCRIPTION)
    stamp_unit: StampUnit = Field(default="s", description="unit of the stamp, since boot or since 1970")
    form: Form = Field(default="json", description="of a message on the bus: json, keelson, cdr:<type>")

    @model_validator(mode="after")
    def _check_topics(self) -> Self:
        if not self.topic and not all(each.topic for each in self.each):
            raise ValueError("give the topic of the commands, of all together or of each thruster")
        return self

    @model_validator(mode="before")
    @classmethod
    def _default_curve(cls, given: Any) -> Any:
        """A rotor whose speed is commanded gets a quadratic thrust curve where no curve is given."""
        if isinstance(given, Mapping) and given.get("command") in ("rpm", "rad/s"):
            return {"curve": "quadratic", **given}
        return given

    @model_validator(mode="after")
    def _check_curve(self) -> Self:
        if self.command in ("rpm", "rad/s") and self.curve in ("t200", "linear"):
            raise ValueError(
                f"curve is {self.curve}, which belongs to pwm and fraction; with command {self.command} give curve: "
                "quadratic, with full in N s²/rad², or a file of command,newtons"
            )
        return self

    @property
    def topics(self) -> tuple[str, ...]:
        """The topics of the thrusters' commands, in the order of the thrusters."""
        return tuple(topic for topic, _ in self.fields)

    @property
    def fields(self) -> tuple[tuple[str, str], ...]:
        """Topic and path of each thruster's command."""
        return tuple((each.topic or self.topic, each.field) for each in self.each)

    def places(self) -> Iterator[Place]:
        """The sources of the commands, then of the battery's voltage and the angles."""
        for number, (each, topic) in enumerate(zip(self.each, self.topics, strict=True)):
            yield Place(f"thrusters.each.{number}", topic, self.form, each.field, self.stamp, self.stamp_unit)
            if each.turned_by is not None:
                yield Place.of(f"thrusters.each.{number}.turned_by", each.turned_by)
        if self.measured_voltage is not None:
            yield Place.of("thrusters.measured_voltage", self.measured_voltage)


_PRESETS = ", ".join(name if name in ON_BUS else f"{name} (logs alone)" for name in NAMES[:-1])


class Inputs(Section):
    """The inputs in other forms than our own; the preset gives those that are left out."""

    preset: PresetName | None = Field(
        default=None,
        description=f"{_PRESETS} or incsvr; null: own keys on the bus, detected in logs",
    )
    yaw_rate: Source | None = Field(default=None, description="source of the yaw rate: topic, field, unit, …")
    torque: Source | None = Field(default=None, description="source of the torque, if it is measured or published")
    thrusters: Thrusters | None = Field(default=None, description="or the thrusters' commands, and their lever arms")
    channels: dict[Name, Source] = Field(default={}, description="further channels by name")
    armed: Armed | None = Field(default=None, description="source of the armed state")
    system: str = Field(
        default="", description="number of the vehicle, such as 2; empty: the first that is armed and moves"
    )
    parameters: dict[str, float] = Field(
        default={}, description="parameters of the vehicle, such as FRAME_CONFIG, where it does not send them"
    )
    velocity_frame: Literal["body", "north_east", "east_north"] = Field(
        default="body",
        description="axes of a log's surge and sway: body, or north and east, turned into the body by the heading",
    )
    velocity_north: float = Field(
        default=0.0, description="heading of that north, where a log's frame has one of its own [rad]"
    )
    velocity_place: Vector = Field(
        default=(0.0, 0.0, 0.0),
        description="place at which a log's velocities are measured, ahead first, from where the efforts act [m]",
    )

    @field_validator("system", mode="before")
    @classmethod
    def _name_system(cls, system: object) -> object:
        return str(system) if isinstance(system, int) and not isinstance(system, bool) else system

    def places(self) -> Iterator[Place]:
        """All sources that it names."""
        for name, source in (("yaw_rate", self.yaw_rate), ("torque", self.torque), ("armed", self.armed)):
            if source is not None:
                yield Place.of(name, source)
        for name, channel in self.channels.items():
            yield Place.of(f"channels.{name}", channel)
        if self.thrusters is not None:
            yield from self.thrusters.places()

    @property
    def sources(self) -> dict[str, Source]:
        """The sources of its streams by name, the yaw rate's first."""
        return self.sources_of("yaw_rate", "torque")

    def sources_of(self, rate: str, effort: str) -> dict[str, Source]:
        """The sources of its streams by name, where the velocity and the effort of an axis have these names."""
        channels = {name: source for name, source in self.channels.items() if name not in (rate, effort)}
        named = {rate: self.yaw_rate, **channels, effort: self.torque}
        return {name: source for name, source in named.items() if source is not None}

    @property
    def own(self) -> bool:
        """Whether all comes in our own form on our own keys."""
        rest = self.model_copy(update={"preset": None})
        return self.preset in (None, "incsvr") and rest == Inputs()

    @model_validator(mode="after")
    def _check_one_torque(self) -> Self:
        if self.torque is not None and self.thrusters is not None:
            raise ValueError("torque and thrusters are both given; leave one of them out")
        return self


Places = Callable[[str, Any, str], dict[str, Any]]
"""What changes of a source (its `topic`, `field`, `stamp` or `stamp_unit`), by the name of its quantity, the source and
the topic that it names."""


def inside(path: str, fields: Collection[str]) -> str:
    """A path where it stands in a message with these fields: in JSON those of MAVLink are within `message`."""
    return f"message.{path}" if path and path not in fields and f"message.{path}" in fields else path


def renamed(inputs: Inputs, places: Places) -> Inputs:
    """The mapping with the places of all sources."""

    def at(name: str, source: Any) -> Any:
        return None if source is None else source.model_copy(update=places(name, source, source.topic))

    def thruster(one: Thruster, common: str) -> Thruster:
        changed = {
            name: each
            for name, each in places("command", one, one.topic or common).items()
            if name in ("topic", "field")
        }
        return one.model_copy(update={**changed, "turned_by": at("turned_by", one.turned_by)})

    thrusters = inputs.thrusters
    if thrusters is not None:
        each = tuple(thruster(one, thrusters.topic) for one in thrusters.each)
        stamped = places("commands", thrusters, thrusters.topics[0])
        changed: dict[str, Any] = {name: stamped[name] for name in ("stamp", "stamp_unit") if name in stamped}
        voltage = at("voltage", thrusters.measured_voltage)
        thrusters = thrusters.model_copy(update={**changed, "each": each, "measured_voltage": voltage})
    return inputs.model_copy(
        update={
            **{name: at(name, getattr(inputs, name)) for name in ("yaw_rate", "torque", "armed")},
            "channels": {name: at(name, source) for name, source in inputs.channels.items()},
            "thrusters": thrusters,
        }
    )
