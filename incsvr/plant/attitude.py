"""η: how a body stands in the world, J(η) of Eq. 1, and the weight and buoyancy that follow from it, g(η) of Eq. 2.

Angles are those of roll φ, pitch θ and yaw ψ, in the order z, y, x; z points down (SNAME). Equations of T. I. Fossen,
Handbook of Marine Craft Hydrodynamics and Motion Control, 2011.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from incsvr.numerics import Array

Point = tuple[float, float, float]

ATTITUDE = ("roll", "pitch")
"""φ and θ [rad], as recordings and streams call them."""


def rotation(roll: float, pitch: float, yaw: float) -> Array:
    """R(Θ), (3, 3): from the body to the world (Fossen, Eq. 2.18)."""
    (cx, cy, cz), (sx, sy, sz) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cx, -sx], [0.0, sx, cx]])
    about_y = np.array([[cy, 0.0, sy], [0.0, 1.0, 0.0], [-sy, 0.0, cy]])
    about_z = np.array([[cz, -sz, 0.0], [sz, cz, 0.0], [0.0, 0.0, 1.0]])
    turned: Array = about_z @ about_y @ about_x
    return turned


def kinematics(roll: float, pitch: float, yaw: float) -> Array:
    """J(η), (6, 6): η̇ = J(η) ν (Fossen, Eq. 2.40); without value where the pitch is ± 90°."""
    c, s, t = np.cos(roll), np.sin(roll), np.tan(pitch)
    rates = np.array([[1.0, s * t, c * t], [0.0, c, -s], [0.0, s / np.cos(pitch), c / np.cos(pitch)]])
    nothing = np.zeros((3, 3))
    return np.block([[rotation(roll, pitch, yaw), nothing], [nothing, rates]])


@dataclass(frozen=True, slots=True)
class Restoring:
    """The forces of weight and buoyancy on a body that is fully under water.

    Attributes:
        weight: W [N].
        buoyancy: B [N].
        centre_of_gravity, centre_of_buoyancy: from the origin [m].
    """

    weight: float
    buoyancy: float
    centre_of_gravity: Point
    centre_of_buoyancy: Point

    def force(self, roll: Array, pitch: Array) -> Array:
        """g(η), (n, 6) [N] and [N m] on the left of Eq. 2 (Fossen, Eq. 4.6), at (n,) angles [rad]."""
        down = np.column_stack([-np.sin(pitch), np.cos(pitch) * np.sin(roll), np.cos(pitch) * np.cos(roll)])
        weight, lift = self.weight * down, -self.buoyancy * down
        moment = _about(self.centre_of_gravity, weight) + _about(self.centre_of_buoyancy, lift)
        taken: Array = -np.hstack([weight + lift, moment])
        return taken


def _about(point: Sequence[float], force: Array) -> Array:
    """(n, 3) the moment about the origin of (n, 3) forces that act at a point."""
    x, y, z = point
    fx, fy, fz = force.T
    return np.column_stack([y * fz - z * fy, z * fx - x * fz, x * fy - y * fx])
