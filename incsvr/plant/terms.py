"""The terms of a vehicle's equations that are linear in their coefficient: damping, couplings, thrust, restoring.

Each term takes a force or moment from an axis: M ν̇ + C(ν) ν + Σ c φ(ν, τ, η) = τ. Port and starboard of a hull mirror
each other unless data say otherwise, which decides which products may push along which axis (T. I. Fossen, Handbook of
Marine Craft Hydrodynamics and Motion Control, 2011, Section 7.2).
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from itertools import combinations

from incsvr.plant.axes import AXES, LATERAL, VELOCITIES, Axis

LINEAR, QUADRATIC = "linear", "quadratic"
"""Kinds of damping of an axis by its own velocity: c ν and c ν|ν|."""
CROSS, CROSS_SIZE, PRODUCT, SQUARE = "cross", "cross_size", "product", "square"
"""c ν_j; c |ν_j| ν_k; c ν_j ν_k; c ν_j²."""
EFFORT, INFLOW, REVERSE, BIAS = "effort", "inflow", "reverse", "bias"
"""Terms of an effort: another axis's, −c τ_j; lost with speed, c τ |ν_j|; weak in reverse, c τ if τ < 0; a constant."""
WEIGHT, RIGHTING = "weight", "righting"
"""Weight less buoyancy, −c times the downward direction; the righting moment, c sin φ cos θ or c sin θ."""


@dataclass(frozen=True, slots=True)
class Term:
    """One term c φ of one axis.

    Attributes:
        axis: name of the axis whose effort it takes.
        kind: one of the kinds above.
        of: names of the velocities or the axis that it depends on.
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
    def dissipates(self) -> bool:
        """Whether its coefficient may not be negative: damping never drives."""
        return self.kind in (LINEAR, QUADRATIC) or (self.kind == CROSS_SIZE and self.of[1] == AXES[self.axis].rate)

    @property
    def unit(self) -> str:
        """Unit of its coefficient."""
        axis = AXES[self.axis]
        force = "N" if axis.along else "N m"
        speeds = [AXES_BY_RATE[name] for name in self.of if name in VELOCITIES]
        if self.kind == LINEAR:
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


def own_damping(axes: Collection[str]) -> tuple[Term, ...]:
    """Linear and quadratic damping of each axis."""
    return tuple(Term(name, kind) for name in AXES if name in axes for kind in (LINEAR, QUADRATIC))


def restoring(axes: Collection[str], recorded: Collection[str]) -> tuple[Term, ...]:
    """Restoring terms of the axes that turn with roll and pitch, where these angles are recorded."""
    found = [Term(name, RIGHTING) for name in ("roll", "pitch") if name in axes and name in recorded]
    if "heave" in axes and {"roll", "pitch"} & set(recorded):
        found.append(Term("heave", WEIGHT))
    return tuple(found)


def couplings(axes: Collection[str], driven: Collection[str], recorded: Collection[str]) -> tuple[Term, ...]:
    """Terms by which the axes of a hull act on each other beside C(ν) ν, to second order.

    Args:
        axes: names of the axes that are modelled.
        driven: those of them whose effort is recorded and moves.
        recorded: names of recorded velocities.
    """
    speeds = [name for name in VELOCITIES if name in recorded]
    lateral = [name for name in speeds if name in LATERAL]
    found: list[Term] = []
    for axis in (AXES[name] for name in AXES if name in axes):
        if axis.rate in LATERAL:
            found += [Term(axis.name, CROSS, (name,)) for name in lateral if name != axis.rate]
            found += [Term(axis.name, PRODUCT, (a, b)) for a in speeds if a not in LATERAL for b in lateral]
        else:
            found += [Term(axis.name, SQUARE, (name,)) for name in lateral]
            found += [Term(axis.name, PRODUCT, pair) for pair in combinations(lateral, 2)]
        if axis.name not in driven:
            found += [Term(axis.name, EFFORT, (name,)) for name in driven if _mirror_alike(axis, AXES[name])]
    return tuple(found)


def extras(axes: Collection[str], driven: Collection[str], recorded: Collection[str]) -> tuple[Term, ...]:
    """Terms that few vehicles need: drag that grows with another velocity, thrust that falls with speed, weak reverse
    thrust, an effort that acts on another axis, a constant. Arguments as of `couplings`."""
    speeds = [name for name in VELOCITIES if name in recorded]
    found: list[Term] = []
    for axis in (AXES[name] for name in AXES if name in axes):
        found += [Term(axis.name, CROSS_SIZE, (name, axis.rate)) for name in speeds if name != axis.rate]
        if axis.name in driven:
            found += [Term(axis.name, INFLOW, (name,)) for name in ("surge", axis.rate) if name in speeds]
            found += [Term(axis.name, REVERSE), *(Term(axis.name, EFFORT, (k,)) for k in driven if k != axis.name)]
        found.append(Term(axis.name, BIAS))
    return tuple(dict.fromkeys(found))


def _per_speeds(along: int, about: int) -> str:
    """The unit of one over a product of so many velocities [m/s] and angular velocities [rad/s]."""
    parts = [name if count == 1 else f"{name}²" for name, count in (("m", along), ("rad", about)) if count]
    seconds = "s" if along + about == 1 else "s²"
    below = " ".join(parts)
    return "" if not parts else f"{seconds}/{below}" if len(parts) == 1 else f"{seconds}/({below})"


def _mirror_alike(one: Axis, other: Axis) -> bool:
    """Whether both axes change their sign where port and starboard change places, or neither does."""
    return (one.rate in LATERAL) == (other.rate in LATERAL)
