"""The six axes of a body-fixed frame (SNAME, 1950): what each is called in recordings, and its units."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations


@dataclass(frozen=True, slots=True)
class Axis:
    """One degree of freedom.

    Attributes:
        name: as people say it.
        rate: column of its velocity, [m/s] along an axis, [rad/s] about one.
        effort: column of what the actuators apply: a force [N] along an axis, a moment [N m] about one.
        fastest: the velocity beyond which a recording is probably in another unit: about a turn a second [rad/s], and
            40 knots [m/s], which no vehicle under water and few above it reach.
        products: pairs of other velocities whose products push along this axis: those in its row of C(ν)ν, M diagonal;
            in surge also what a centre of gravity ahead of the origin makes of the turn, m x_g (q² + r²), and the
            hull's drag at an angle of drift, X_vv v² + X_ww w².
    """

    name: str
    rate: str
    effort: str
    fastest: float
    products: tuple[tuple[str, str], ...]

    @property
    def along(self) -> bool:
        """Whether it is one of translation: velocities in m/s, forces in N, masses in kg."""
        return self.force_symbol in "XYZ"

    @property
    def symbol(self) -> str:
        """SNAME's letter of its velocity."""
        return "uvwpqr"[list(AXES).index(self.name)]

    @property
    def force_symbol(self) -> str:
        """SNAME's letter of the force along it, or the moment about it."""
        return "XYZKMN"[list(AXES).index(self.name)]


_EVEN = tuple((name, name) for name in ("sway", "heave", "pitch_rate", "yaw_rate"))

AXES = {
    axis.name: axis
    for axis in (
        Axis("surge", "surge", "surge_force", 20.0, (("sway", "yaw_rate"), ("heave", "pitch_rate"), *_EVEN)),
        Axis("sway", "sway", "sway_force", 20.0, (("surge", "yaw_rate"), ("heave", "roll_rate"))),
        Axis("heave", "heave", "heave_force", 20.0, (("surge", "pitch_rate"), ("sway", "roll_rate"))),
        Axis("roll", "roll_rate", "roll_torque", 6.0, (("sway", "heave"), ("pitch_rate", "yaw_rate"))),
        Axis("pitch", "pitch_rate", "pitch_torque", 6.0, (("surge", "heave"), ("roll_rate", "yaw_rate"))),
        Axis("yaw", "yaw_rate", "torque", 6.0, (("surge", "sway"), ("roll_rate", "pitch_rate"))),
    )
}
"""The axes by name, in the order of ν."""

YAW = AXES["yaw"]

VELOCITIES = tuple(axis.rate for axis in AXES.values())
"""ν = (u, v, w, p, q, r) as recordings call it."""

EFFORTS = tuple(axis.effort for axis in AXES.values())
"""τ: what the actuators apply along and about each."""


BODY_YAW_RATE = "body_yaw_rate"
"""The stream of the vehicle's yaw rate beside the two of another axis, one of which is called yaw_rate as well."""


def stream_of(axis: Axis, velocity: str) -> str:
    """The name under which another velocity of the body comes beside the two streams of an axis."""
    return BODY_YAW_RATE if axis != YAW and velocity == YAW.rate else velocity


def of_rate(rate: str) -> Axis:
    """The axis whose velocity is in this column."""
    return next(axis for axis in AXES.values() if axis.rate == rate)


LATERAL = frozenset(("sway", "roll_rate", "yaw_rate"))
"""Velocities that change their sign where port and starboard change places; the others do not."""

_SYMMETRIC = (frozenset(VELOCITIES) - LATERAL, LATERAL)


def accelerating(axis: Axis, recorded: tuple[str, ...]) -> tuple[str, ...]:
    """Velocities whose change takes of the axis's force where M is not diagonal, of those that are recorded: in a body
    whose port is the mirror of its starboard (Fossen 2011, Eq. 7.22) those of the same group alone."""
    group = next(group for group in _SYMMETRIC if axis.rate in group)
    return tuple(name for name in recorded if name in group and name != axis.rate)


def products(axis: Axis, recorded: tuple[str, ...]) -> tuple[tuple[str, str], ...]:
    """Pairs of velocities whose product may push along the axis, of those that are recorded beside its own.

    Those of the axis, and the own velocity with every other one: what a centre of gravity off the origin and lift add
    (m x_g u r, Y_uv u v).
    """
    own = tuple((a, b) for a, b in combinations(VELOCITIES, 2) if axis.rate in (a, b))
    known = {axis.rate, *recorded}
    return tuple(pair for pair in (*axis.products, *own) if known.issuperset(pair))
