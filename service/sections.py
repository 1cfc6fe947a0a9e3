"""The sections of the configuration: every value with its default, its bounds, its unit and a sentence."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, field_validator, model_validator

from incsvr.learning.learner import Settings as LearnerSettings
from incsvr.plant.attitude import Restoring
from incsvr.plant.axes import AXES
from incsvr.plant.inertia import mass_matrix
from incsvr.signals import MAX_CHANNELS
from incsvr.signals.settings import TorqueKind
from service.endpoint import listens_everywhere


def shaped(pattern: str, sentence: str) -> AfterValidator:
    """A text that matches the whole pattern; a person who wrote another one is told the sentence."""

    def checked(text: str) -> str:
        if re.fullmatch(pattern, text) is None:
            raise ValueError(sentence)
        return text

    return AfterValidator(checked)


Endpoint = Annotated[
    str,
    shaped(
        r"(tcp|tls|quic|ws|unixsock-stream)/\S+",
        "write an endpoint as in tcp/127.0.0.1:7447; it begins with tcp/, tls/, quic/, ws/ or unixsock-stream/",
    ),
]
Name = Annotated[
    str,
    Field(max_length=64),
    shaped(r"[A-Za-z0-9_.-]+", "a name has letters without accents, digits, _, . and - alone"),
]
Prefix = Annotated[
    str,
    Field(max_length=128),
    shaped(
        r"[A-Za-z0-9_.-]+(/[A-Za-z0-9_.-]+)*",
        "a prefix is names with slashes between them, such as leng/yaw; a name has letters from a to z, digits, _, . "
        "and - alone",
    ),
]


def _row_by_row(given: Any) -> Any:
    """Six rows of six as the 36 entries that they are."""
    rows = given if isinstance(given, list | tuple) else ()
    whole = len(rows) > 0 and all(isinstance(row, list | tuple) for row in rows)
    return [entry for row in rows for entry in row] if whole else given


def _of_a_body(entries: tuple[float, ...]) -> tuple[float, ...]:
    mass_matrix(entries)
    return entries


MassMatrix = Annotated[tuple[float, ...], BeforeValidator(_row_by_row), AfterValidator(_of_a_body)]
Metres = Annotated[float, Field(ge=-100.0, le=100.0)]
Positive = Annotated[float, Field(gt=0.0, le=1e6)]
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

    allow_second: bool = Field(
        default=False, description="whether it starts although another learner has its prefix on the bus"
    )

    @field_validator("listen")
    @classmethod
    def _not_everywhere(cls, endpoint: str) -> str:
        if listens_everywhere(endpoint):
            raise ValueError("this listens on all interfaces; name one address, or give a zenoh_file with TLS")
        return endpoint


class Vehicle(Section):
    """Whose damping it is."""

    name: Name = Field(default="leng", description="the vehicle; a state of another one is refused")
    axis: Literal["surge", "sway", "heave", "roll", "pitch", "yaw"] = Field(
        default="yaw", description="whose velocity and force are learned; m/s, N and kg along an axis"
    )
    inertia: float = Field(default=350.0, gt=0.0, le=1e7, description="dry and added mass about yaw [kg m²]")
    mass_matrix: MassMatrix | None = Field(
        default=None,
        description="M with added mass, surge to yaw [kg], [kg m²]: its diagonal, or 36 entries row by row, instead of "
        "inertia; null takes the axis by itself",
    )
    weight: float | None = Field(
        default=None,
        gt=0.0,
        le=1e9,
        description="W [N], where weight and buoyancy are no part of the damping",
    )
    buoyancy: float | None = Field(default=None, gt=0.0, le=1e9, description="B [N]; null where it is the weight")
    centre_of_gravity: tuple[Metres, Metres, Metres] = Field(
        default=(0.0, 0.0, 0.0), description="from the origin: ahead, to starboard, below [m]"
    )
    centre_of_buoyancy: tuple[Metres, Metres, Metres] = Field(default=(0.0, 0.0, 0.0), description="likewise [m]")
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

    @model_validator(mode="after")
    def _weighed(self) -> Self:
        about = [name for name in ("buoyancy", "centre_of_gravity", "centre_of_buoyancy") if _given(self, name)]
        if self.weight is None and about:
            raise ValueError(f"{about[0]} says nothing without a weight; give weight [N] as well")
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


class Signals(Section):
    """How two streams become samples."""

    sample_period: float = Field(default=0.6, gt=0.0, le=60.0, description="between two samples [s]")
    smoothing: float = Field(
        default=0.12, gt=0.0, le=10.0, description="standard deviation of the Gaussian low-pass [s]"
    )
    lateness: float = Field(default=0.2, ge=0.0, le=10.0, description="how far out of order a message may come [s]")
    gap: float | None = Field(
        default=None,
        gt=0.0,
        lt=5.0,
        description="longest pause that is bridged [s], at most 2 smoothing; null follows the streams",
    )
    torque: TorqueKind | None = Field(
        default=None,
        description="measured, or commanded: it holds until the next one; null: commanded where it is slow and repeats",
    )
    channels: tuple[Name, ...] = Field(
        default=(), max_length=MAX_CHANNELS, description="channels that samples wait for"
    )

    @model_validator(mode="after")
    def _bridged(self) -> Self:
        if self.gap is not None and self.gap > 2.0 * self.smoothing:
            raise ValueError("gap is longer than twice the smoothing: the filter would bridge what it has not seen")
        return self


class Learner(Section):
    """How it learns; γ, C, ε as tuned in Section IV-B of the paper, the rest from III-C."""

    policy: Literal["paper", "weighted"] = Field(default=LearnerSettings().policy, description="which samples are kept")
    solver: Literal["exact", "passes"] = Field(default="exact", description="exact, or Eq. 8's passes")
    gamma: float = Field(default=10.0, gt=0.0, le=1e6, description="kernel width [(rad/s)⁻²]")
    C: float = Field(default=1000.0, gt=0.0, le=1e9, description="bound of a vector's weight [N m]")
    epsilon: float = Field(default=0.1, ge=0.0, le=1e6, description="half height of the tube [N m]")
    capacity: int = Field(default=60, ge=2, le=600, description="support vectors served at most")
    batch: int = Field(default=50, ge=2, le=1000, description="samples of one iteration")
    near_rate: float = Field(default=0.01, gt=0.0, le=10.0, description="a of the inclusion criterion [rad/s]")
    near_damping: float = Field(default=5.0, gt=0.0, le=1e6, description="b of the inclusion criterion [N m]")
    bins: int = Field(default=20, ge=1, le=1000, description="bins of the forgetting criterion")
    inputs: tuple[Name, ...] = Field(
        default=("yaw_rate",),
        min_length=1,
        max_length=6,
        description="velocities that damping is learned over, the axis's own first; docs/several_velocities.md",
    )
    fastest: dict[Name, Positive] = Field(
        default={}, description="fastest value of a further input, by which it is scaled; else as it was driven"
    )
    near: dict[Name, Positive] = Field(
        default={}, description="a of the inclusion criterion of a further input; else near_rate as a part of fastest"
    )

    @model_validator(mode="after")
    def _over_several(self) -> Self:
        further = self.inputs[1:]
        if further and self.solver == "passes":
            raise ValueError("the passes of Eq. 8 are for one velocity; set solver to exact or leave one input")
        for name, given in (("fastest", self.fastest), ("near", self.near)):
            foreign = [each for each in given if each not in further]
            if foreign:
                known = ", ".join(further) or "none"
                raise ValueError(f"{name} names {foreign[0]}, which is no further input (they are: {known})")
        return self


class HealthLimits(Section):
    """When health warns, and where it goes besides."""

    stale_after: Seconds = Field(default=2.0, description="a stream silent for longer makes it STALE [s], wall time")
    stuck_after: Seconds = Field(default=2.0, description="a yaw rate that stands still for longer is a fault [s]")
    warn_for: Seconds = Field(default=10.0, description="how long a rejected sample is remembered [s], wall time")
    fresh_for: Seconds = Field(
        default=900.0, description="how long a sample counts as fresh in `learned` [s], vehicle's time"
    )
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
    """Whether the learner traces what its model lacks by itself, in a process beside it."""

    live: Literal["off", "advise", "adopt"] = Field(
        default="off",
        description="off; advise: says what is found and an operator decides; adopt: takes up what is proven",
    )
    window: Seconds = Field(default=900.0, description="the recent data that are kept for it [s], vehicle's time")
    proof: Seconds = Field(default=300.0, description="fresh data that effects must prove themselves on [s]")

    @field_validator("live", mode="before")
    @classmethod
    def _yes_or_no(cls, mode: object) -> object:
        """Earlier files say true or false; and YAML reads a bare `off` as false, a bare `on` as true."""
        said = {"true": "adopt", "false": "off"}
        return said.get(str(mode).lower(), mode)

    @property
    def on(self) -> bool:
        """Whether anything is traced while the learner learns."""
        return self.live != "off"

    @model_validator(mode="after")
    def _learned_before(self) -> Self:
        if self.proof > 0.5 * self.window:
            raise ValueError("proof is more than half the window: too little is left to learn from before it")
        return self


class Archive(Section):
    """Whether all that comes in and goes out is kept, as MCAP files."""

    directory: Path | None = Field(default=None, description="where they are; null keeps none")
    file_mb: int = Field(default=32, ge=1, le=10_000, description="size at which another file is begun [MB]")
    most_mb: int = Field(default=2_000, ge=4, le=10_000_000, description="of all learners together; the oldest go [MB]")

    @model_validator(mode="after")
    def _several(self) -> Self:
        if self.most_mb < 2 * self.file_mb + 2:
            raise ValueError("most_mb must hold two files of file_mb and 2 MB more")
        return self


class Simulation(Section):
    """What `incsvr simulate` plays: Leng's experiment and the faults of its sensors."""

    seed: int = Field(default=1, ge=0, le=2**32 - 1, description="the same seed plays the same")
    runs: tuple[Literal["V1", "T1", "V2", "T2", "planar"], ...] = Field(
        default=("T1", "T2"),
        min_length=1,
        description="in this order; planar is another vehicle, whose damping couples surge, sway and yaw",
    )
    underway: int | None = Field(
        default=None,
        ge=0,
        le=2**32 - 1,
        description="seed of an effect that comes on afterwards, while the vehicle goes on; null: it does not go on",
    )
    drop_outs: float = Field(default=0.0, ge=0.0, le=60.0, description="drop-outs of a stream per minute")
    drop_out_length: Seconds = Field(default=1.0, description="mean length of a drop-out [s]")
    jitter: float = Field(default=0.0, ge=0.0, le=1.0, description="messages come out of order by up to this [s]")
    duplicates: float = Field(default=0.0, ge=0.0, le=0.5, description="part of the messages that come twice")
