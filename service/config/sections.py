"""The sections of the configuration: every value with its default, its bounds, its unit and a sentence."""

from __future__ import annotations

import ipaddress
import socket
from pathlib import Path
from typing import Literal, Self

from pydantic import BaseModel, Field, field_validator, model_validator

from incsvr.learning.learner import Settings as LearnerSettings
from incsvr.plant.attitude import Restoring
from incsvr.plant.axes import AXES
from incsvr.plant.mass_and_coriolis import mass_matrix
from incsvr.signals import MAX_CHANNELS
from incsvr.signals.settings import TorqueKind
from service.wire.section import Endpoint, MassMatrix, Metres, Name, Names, Positive, Seconds, Section


class Vehicle(Section):
    """The vehicle whose damping is learned."""

    name: Name = Field(default="leng", description="name of the vehicle; a state of another vehicle is refused")
    axis: Literal["surge", "sway", "heave", "roll", "pitch", "yaw"] = Field(
        default="yaw", description="whose velocity and force are learned; m/s, N and kg along an axis"
    )
    inertia: float = Field(default=350.0, gt=0.0, le=1e7, description="dry and added mass about yaw [kg m²]")
    mass_matrix: MassMatrix | None = Field(
        default=None,
        description="M with added mass, surge to yaw [kg], [kg m²]: its diagonal, or 36 entries row by row, "
        "instead of inertia; null: the axis alone",
    )
    weight: float | None = Field(
        default=None,
        gt=0.0,
        le=1e9,
        description="weight W [N], to separate restoring moments from the damping",
    )
    buoyancy: float | None = Field(
        default=None, gt=0.0, le=1e9, description="buoyancy B [N]; null: equal to the weight"
    )
    centre_of_gravity: tuple[Metres, Metres, Metres] = Field(
        default=(0.0, 0.0, 0.0), description="from the origin: ahead, to starboard, below [m]"
    )
    centre_of_buoyancy: tuple[Metres, Metres, Metres] = Field(default=(0.0, 0.0, 0.0), description="likewise [m]")
    rate_range: tuple[float, float] = Field(
        default=(-0.25, 0.25), description="lowest and highest yaw rate it reaches [rad/s]"
    )
    rate_limit: float = Field(default=1.0, gt=0.0, le=50.0, description="largest plausible yaw rate [rad/s]")
    torque_limit: float = Field(default=500.0, gt=0.0, le=1e7, description="largest plausible torque [N m]")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        low, high = self.rate_range
        if not -self.rate_limit <= low < high <= self.rate_limit:
            raise ValueError("rate_range needs its lower end first, and both within ± rate_limit")
        return self

    @model_validator(mode="after")
    def _weighed(self) -> Self:
        about = [name for name in ("buoyancy", "centre_of_gravity", "centre_of_buoyancy") if _given(self, name)]
        if self.weight is None and about:
            raise ValueError(f"{about[0]} needs a weight; give weight [N] as well")
        return self

    @model_validator(mode="after")
    def _of_one_inertia(self) -> Self:
        """The mass matrix says what the inertia of the axis is."""
        if self.mass_matrix is None:
            return self
        own = list(AXES).index(self.axis)
        inertia = float(mass_matrix(self.mass_matrix)[own, own])
        if not inertia > 0.0:
            raise ValueError(f"mass_matrix has {inertia:g} for {self.axis}, the axis that is learned; give its inertia")
        if "inertia" in self.model_fields_set and self.inertia != inertia:
            raise ValueError(
                f"inertia is {self.inertia:g}, and mass_matrix has {inertia:g} for {self.axis}; leave out inertia"
            )
        object.__setattr__(self, "inertia", inertia)
        return self

    @property
    def inertia_said(self) -> bool:
        """Whether somebody said the inertia, or that it is Leng, whose is known."""
        leng = "name" in self.model_fields_set and self.name == "leng" and self.axis == "yaw"
        return "inertia" in self.model_fields_set or self.mass_matrix is not None or leng

    @property
    def restoring(self) -> Restoring | None:
        """Weight and buoyancy; None where they are left out."""
        if self.weight is None:
            return None
        lift = self.weight if self.buoyancy is None else self.buoyancy
        return Restoring(self.weight, lift, self.centre_of_gravity, self.centre_of_buoyancy)


def _given(section: BaseModel, name: str) -> bool:
    """Whether a value is not as it is by default."""
    return bool(getattr(section, name) != type(section).model_fields[name].default)


def listens_everywhere(endpoint: str) -> bool:
    """Whether a listener at this Zenoh endpoint, such as tcp/127.0.0.1:7447, is met on all interfaces."""
    protocol, _, place = endpoint.partition("/")
    if protocol.startswith("unixsock"):
        return False
    address = place.partition("?")[0].partition("#")[0]
    host = address.rpartition(":")[0].removeprefix("[").removesuffix("]")
    if not host or host == "*":
        return True
    try:
        found = {entry[4][0] for entry in socket.getaddrinfo(host.partition("%")[0], None)}
    except (OSError, UnicodeError):
        return False  # nothing can listen there; opening the bus will say so
    return any(_unspecified(str(each)) for each in found)


def _unspecified(address: str) -> bool:
    found = ipaddress.ip_address(address)
    mapped = found.ipv4_mapped if isinstance(found, ipaddress.IPv6Address) else None
    return found.is_unspecified or (mapped is not None and mapped.is_unspecified)


class Bus(Section):
    """The endpoints of the learner."""

    listen: Endpoint = Field(
        default="tcp/127.0.0.1:7447", description="endpoint at which the learner listens; loopback"
    )
    connect: Endpoint | None = Field(
        default=None, description="endpoint of an existing router; the learner is its client then"
    )
    zenoh_file: Path | None = Field(default=None, description="a Zenoh JSON5 file (TLS, access control), used as it is")

    allow_second: bool = Field(default=False, description="start although another learner uses the prefix on the bus")

    @field_validator("listen")
    @classmethod
    def _not_everywhere(cls, endpoint: str) -> str:
        if listens_everywhere(endpoint):
            raise ValueError("this listens on all interfaces; name one address, or give a zenoh_file with TLS")
        return endpoint


class Signals(Section):
    """The settings by which two streams become samples."""

    sample_period: float = Field(default=0.6, gt=0.0, le=60.0, description="between two samples [s]")
    smoothing: float = Field(
        default=0.12, gt=0.0, le=10.0, description="standard deviation of the Gaussian low-pass [s]"
    )
    lateness: float = Field(default=0.2, ge=0.0, le=10.0, description="largest disorder of messages that is sorted [s]")
    gap: float | None = Field(
        default=None,
        gt=0.0,
        lt=5.0,
        description="longest pause that is bridged [s], at most twice signals.smoothing; null: as the streams need",
    )
    torque: TorqueKind | None = Field(
        default=None,
        description="measured, or commanded: constant until the next one; null: commanded where it is slow and repeats",
    )
    channels: tuple[Name, ...] = Field(
        default=(), max_length=MAX_CHANNELS, description="further channels that every sample needs"
    )

    @model_validator(mode="after")
    def _bridged(self) -> Self:
        if self.gap is not None and self.gap > 2.0 * self.smoothing:
            raise ValueError("gap is longer than twice the smoothing: the filter would bridge unmeasured time")
        return self


class Learner(Section):
    """The settings of the learner; γ, C, ε as tuned in Section IV-B of the paper, the rest from III-C."""

    policy: Literal["paper", "weighted"] = Field(
        default=LearnerSettings().policy, description="policy that selects the samples to keep"
    )
    solver: Literal["exact", "passes"] = Field(default="exact", description="exact, or passes (Eq. 8)")
    gamma: float = Field(default=10.0, gt=0.0, le=1e6, description="kernel width [(rad/s)⁻²]")
    C: float = Field(default=1000.0, gt=0.0, le=1e9, description="bound of a vector's weight [N m]")
    epsilon: float = Field(default=0.1, ge=0.0, le=1e6, description="half height of the tube [N m]")
    capacity: int = Field(default=60, ge=2, le=600, description="support vectors served at most")
    batch: int = Field(default=50, ge=2, le=1000, description="samples of one iteration")
    near_rate: float = Field(default=0.01, gt=0.0, le=10.0, description="a of the inclusion criterion [rad/s]")
    near_damping: float = Field(default=5.0, gt=0.0, le=1e6, description="b of the inclusion criterion [N m]")
    inputs: Names = Field(
        default=("yaw_rate",),
        min_length=1,
        max_length=6,
        description="velocities that damping is learned over, the axis's own first; docs/learner.md",
    )
    fastest: dict[Name, Positive] = Field(
        default={}, description="largest value of a further input, its scale; else the largest that was driven"
    )

    @model_validator(mode="after")
    def _over_several(self) -> Self:
        further = self.inputs[1:]
        if further and self.solver == "passes":
            raise ValueError("the passes of Eq. 8 are for one velocity; set solver to exact or leave one input")
        if further and self.policy == "paper":
            raise ValueError("the policy paper is for one velocity; take weighted or leave one input")
        foreign = [each for each in self.fastest if each not in further]
        if foreign:
            known = ", ".join(further) or "none"
            raise ValueError(f"fastest names {foreign[0]}, which is no further input (they are: {known})")
        return self


class HealthLimits(Section):
    """When a silent stream is stale, and where health is published for ROS 2."""

    stale_after: Seconds = Field(default=2.0, description="silence of a stream that makes health STALE [s], wall time")
    diagnostics: str | None = Field(
        default=None, description="key of ROS 2's DiagnosticArray of health; null: beside the Imu with preset ros2"
    )

    @field_validator("diagnostics")
    @classmethod
    def _one_key(cls, key: str | None) -> str | None:
        if key is not None and (not key or key[0] == "/" or key[-1] == "/" or set(key) & set("*$?#") or "//" in key):
            raise ValueError("this is no key to publish on; write names with slashes between them, such as diagnostics")
        return key


class Tracing(Section):
    """Whether a process beside the learner traces what its model lacks."""

    live: Literal["off", "advise", "adopt"] = Field(
        default="off",
        description="off; advise: reports effects, and an operator decides; adopt: puts proven effects in force",
    )
    window: Seconds = Field(default=900.0, description="length of the recent data that are traced [s], vehicle's time")
    proof: Seconds = Field(default=300.0, description="length of the fresh data on which effects are proven [s]")

    @field_validator("live", mode="before")
    @classmethod
    def _yes_or_no(cls, mode: object) -> object:
        """Earlier files say true or false."""
        said = {"true": "adopt", "false": "off"}
        return said.get(str(mode).lower(), mode)

    @property
    def on(self) -> bool:
        """Whether anything is traced while the learner learns."""
        return self.live != "off"

    @model_validator(mode="after")
    def _learned_before(self) -> Self:
        if self.proof > 0.5 * self.window:
            raise ValueError("proof is more than half the window: the data before it are too few to learn from")
        return self


class Archive(Section):
    """Where all messages are kept, as MCAP files."""

    directory: Path | None = Field(default=None, description="folder of the archives; null: no archive")
    most_mb: int = Field(
        default=2_000,
        ge=4,
        le=10_000_000,
        description="largest size of the files of all learners [MB]; the oldest are deleted",
    )
