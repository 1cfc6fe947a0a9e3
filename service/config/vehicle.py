"""The section of the configuration that says whose damping is learned: axis, mass matrix, weight, what is believed."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import BaseModel, Field, model_validator

from incsvr.plant.attitude import Restoring
from incsvr.plant.axes import AXES
from incsvr.plant.mass_and_coriolis import mass_matrix
from service.wire.section import MassMatrix, Metres, Name, Section


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
