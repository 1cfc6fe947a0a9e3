"""The terms of a vehicle's equations that are linear in their coefficient: damping, couplings, thrust, restoring.

Each term takes a force or moment from an axis: M ν̇ + C(ν) ν + Σ c φ(ν, τ, η) = τ. Port and starboard of a hull mirror
each other unless data say otherwise, which decides which products may push along which axis (T. I. Fossen, Handbook of
Marine Craft Hydrodynamics and Motion Control, 2011, Section 7.2).
"""

from __future__ import annotations

from dataclasses import dataclass

from incsvr.plant.axes import AXES, VELOCITIES

LINEAR, QUADRATIC = "linear", "quadratic"
"""Kinds of damping of an axis by its own velocity: c ν and c ν|ν|."""
CROSS, CROSS_SIZE, PRODUCT, SQUARE = "cross", "cross_size", "product", "square"
"""c ν_j; c |ν_j| ν_k, or c |ν_j| where there is one name alone; c ν_j ν_k; c ν_j²."""
EFFORT, INFLOW, REVERSE, BIAS = "effort", "inflow", "reverse", "bias"
"""Terms of an effort: another axis's, −c τ_j; lost with speed, c τ |ν_j|; weak in reverse, c τ if τ < 0; a constant."""
ADVANCE, COULOMB, ASYMMETRY, BEND = "advance", "coulomb", "coulomb_asymmetry", "bend"
"""Thrust lost with the axis's own speed, c ν √|τ|; dry friction c tanh(ν/w), which turns its sign within w; its
difference between both sides, c tanh²(ν/w); the part of ν beyond ± w."""
WEIGHT, RIGHTING = "weight", "righting"
"""Weight less buoyancy, −c times the downward direction; the righting moment, c sin φ cos θ or c sin θ."""


@dataclass(frozen=True, slots=True)
class Term:
    """One term c φ of one axis.

    Attributes:
        axis: name of the axis whose effort it takes.
        kind: one of the kinds above.
        of: names of the velocities or the axis that it depends on, or the width w.
    """

    axis: str
    kind: str
    of: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """The name in tables and vehicle files."""
        return self.kind if not self.of else f"{self.kind}:{'*'.join(self.of)}"

    @property
    def row(self) -> int:
        """Place of its axis in ν."""
        return list(AXES).index(self.axis)

    @property
    def unit(self) -> str:
        """Unit of its coefficient."""
        axis = AXES[self.axis]
        force = "N" if axis.along else "N m"
        speeds = [AXES_BY_RATE[name] for name in self.of if name in VELOCITIES]
        if self.kind == "advance":
            return "√N s/m" if axis.along else "√(N m) s/rad"
        if self.kind in (LINEAR, BEND):
            speeds = [axis]
        elif self.kind in (QUADRATIC, SQUARE):
            speeds = [axis, axis] if self.kind == QUADRATIC else speeds * 2
        per = _per_speeds(sum(each.along for each in speeds), sum(not each.along for each in speeds))
        if self.kind == EFFORT:
            other = AXES[self.of[0]]
            return {(True, False): "1/m", (False, True): "m"}.get((axis.along, other.along), "1")
        if self.kind == INFLOW:
            return per
        return "1" if self.kind == REVERSE else f"{force} {per}".strip()


AXES_BY_RATE = {axis.rate: axis for axis in AXES.values()}
"""Each axis by the name of its velocity."""


def term(axis: str, name: str) -> Term:
    """The term of an axis by its name in tables and vehicle files."""
    kind, _, of = name.partition(":")
    return Term(axis, kind, tuple(of.split("*")) if of else ())


def mass_unit(one: str, other: str) -> str:
    """Unit of the entry of M between two axes."""
    return ("kg m²", "kg m", "kg")[AXES[one].along + AXES[other].along]


STAGE_UNITS = {"exponent": "1", "reverse": "1", "delay_s": "s", "rotor_lag_s": "s"}
"""Units of the stages of an axis's thrust that are no efforts."""


def stage_unit(axis: str, name: str) -> str:
    """The unit of a stage of an axis's thrust in a vehicle file."""
    return STAGE_UNITS.get(name, "N" if AXES[axis].along else "N m")


def thrust_name(name: str) -> str:
    """The name of a stage of thrust for people."""
    return f"thrust {name.removesuffix('_s').replace('_', ' ')}"


def _per_speeds(along: int, about: int) -> str:
    """The unit of one over a product of so many velocities [m/s] and angular velocities [rad/s]."""
    parts = [name if count == 1 else f"{name}²" for name, count in (("m", along), ("rad", about)) if count]
    seconds = "s" if along + about == 1 else "s²"
    below = " ".join(parts)
    return "" if not parts else f"{seconds}/{below}" if len(parts) == 1 else f"{seconds}/({below})"
