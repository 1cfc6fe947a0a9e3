"""M and C(ν) of Eq. 1–2: inertia with added mass, and the Coriolis and centripetal forces that follow from it.

ν = (u, v, w, p, q, r) about an origin that is fixed in the body (SNAME, 1950); equations of T. I. Fossen, Handbook of
Marine Craft Hydrodynamics and Motion Control, 2011.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.axes import AXES

TRACED_INERTIA = "inertia"
"""The effect that is another inertia than the declared one, in the vocabulary of CONTRACT, Section 5."""
ROUNDING = 1e-9
"""Part of its largest entry by which a mass matrix may be asymmetric or short of positive."""
PAIRS = tuple((a, b) for a in range(6) for b in range(a, 6))
"""The 21 pairs of velocities whose products occur in C(ν) ν."""


def rigid_body_mass(mass: float, inertia: Array, centre_of_gravity: Sequence[float]) -> Array:
    """M_RB, (6, 6) (Fossen, Eq. 3.44).

    Args:
        mass: m [kg].
        inertia: (3, 3) moments and products of inertia about the origin [kg m²].
        centre_of_gravity: (x_g, y_g, z_g) [m].
    """
    lever = mass * cross_matrix(np.asarray(centre_of_gravity, dtype=np.float64))
    return np.block([[mass * np.eye(3), -lever], [lever, np.asarray(inertia, dtype=np.float64)]])


def mass_matrix(given: Sequence[float]) -> Array:
    """M = M_RB + M_A, (6, 6), from its diagonal (surge, sway, heave, roll, pitch, yaw) or its 36 entries, row by row.

    An axis that nobody asks about may have zero.

    Raises:
        BadInput: it is neither, not symmetric, or not the inertia of any body.
    """
    values = np.asarray(given, dtype=np.float64)
    if not np.all(np.isfinite(values)):
        raise BadInput("the mass matrix has an entry that is no finite number; give numbers in kg and kg m²")
    if values.size not in (6, 36):
        raise BadInput(
            f"the mass matrix has {values.size} entries; give its diagonal, six numbers from surge to yaw, or all 36, "
            "row by row"
        )
    matrix = np.diag(values) if values.size == 6 else values.reshape(6, 6)
    largest = float(np.max(np.abs(matrix)))
    names = list(AXES)
    for row, column in np.argwhere(np.abs(matrix - matrix.T) > ROUNDING * largest).tolist():
        raise BadInput(
            f"the mass matrix has {matrix[row, column]:g} in {names[row]}, {names[column]} and {matrix[column, row]:g} "
            f"in {names[column]}, {names[row]}; it must be symmetric"
        )
    if largest == 0.0 or float(np.linalg.eigvalsh(matrix)[0]) < -ROUNDING * largest:
        raise BadInput(
            "the mass matrix belongs to no body: no motion may have a negative energy, and some must have one"
        )
    return matrix


def coriolis_matrix(mass: Array, velocity: Array) -> Array:
    """C(ν), (6, 6), skew-symmetric (Fossen, Theorem 3.2), from M (6, 6) and ν (6,)."""
    linear, angular = _momenta(mass, velocity[None])
    above, below = -cross_matrix(linear[0]), -cross_matrix(angular[0])
    return np.block([[np.zeros((3, 3)), above], [above, below]])


def coriolis_force(mass: Array, velocity: Array) -> Array:
    """C(ν) ν, (…, n, 6) [N] and [N m], from M (…, 6, 6) and ν (…, n, 6)."""
    linear, angular = _momenta(mass, velocity)
    along, about = velocity[..., :3], velocity[..., 3:]
    return np.concatenate([_cross(about, linear), _cross(along, linear) + _cross(about, angular)], axis=-1)


def product_weights(mass: Array) -> Array:
    """(…, 6, 21): the coefficients of ν_a ν_b in each row of C(ν) ν, a quadratic form, in the order of `PAIRS`."""
    unit = np.eye(6)
    squares = coriolis_force(mass, unit)
    one, other = np.array(PAIRS).T
    both = coriolis_force(mass, unit[one] + unit[other]) - squares[..., one, :] - squares[..., other, :]
    return np.swapaxes(np.where((one == other)[:, None], squares[..., one, :], both), -1, -2)


def products(mass: Array, axis: int) -> Array:
    """(6, 6), upper triangle: the coefficients of ν_a ν_b in (C(ν) ν)_axis, which is a quadratic form."""
    found = np.zeros((6, 6))
    found[tuple(np.array(PAIRS).T)] = product_weights(mass)[axis]
    return found


def cross_matrix(vector: Array) -> Array:
    """S(a), (3, 3), of a (3,): S(a) b = a × b."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _momenta(mass: Array, velocity: Array) -> tuple[Array, Array]:
    """Linear and angular momentum, (…, n, 3) each: both halves of M ν."""
    momentum = velocity @ np.swapaxes(mass, -1, -2)
    return momentum[..., :3], momentum[..., 3:]


def _cross(a: Array, b: Array) -> Array:
    """a × b over the last axis, without the checks of numpy.cross, which take most of its time on small arrays."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def inertia_in_force(declared: float, findings: Iterable[Mapping[str, Any]]) -> float:
    """The inertia that a model goes by [kg m²]: the traced one where it is among the findings, in the form of CONTRACT,
    Section 5; else the declared one."""
    for finding in findings:
        parameters = finding.get("parameters")
        if finding.get("effect") == TRACED_INERTIA and isinstance(parameters, Mapping):
            value = parameters.get("inertia_kg_m2")
            if isinstance(value, int | float):
                return float(value)
    return declared
