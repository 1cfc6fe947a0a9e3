"""The identified M parted into a rigid body and the water's added mass, as simulators want it.

A log shows only their sum, and only their sum moves the vehicle; the body's own mass decides its weight.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.axes import AXES
from incsvr.vehicle import Vehicle

ALONG, ABOUT = slice(0, 3), slice(3, 6)
"""Places of the translations and of the rotations in ν."""


@dataclass(frozen=True, slots=True)
class RigidBody:
    """A rigid body whose centre of mass is at the origin, and the rest of M.

    Attributes:
        mass: m [kg]; None where no translation was identified.
        inertia: (3,) moments about roll, pitch and yaw [kg m²]; None where no rotation was identified.
        added: (6, 6) M less that body; zero in the rows of axes that were not identified.
        declared: whether somebody gave the mass and the moments.
    """

    mass: float | None
    inertia: Array | None
    added: Array
    declared: bool


def parted(vehicle: Vehicle, mass: float | None = None, inertia: tuple[float, float, float] | None = None) -> RigidBody:
    """M in two parts.

    Args:
        mass: of the body alone [kg]; None takes what the identified axes admit at most.
        inertia: of the body alone about roll, pitch and yaw [kg m²]; None likewise, the same about all three.

    Raises:
        BadInput: the body alone has more inertia than body and water together.
    """
    rows = vehicle.structure.rows
    total = np.zeros((6, 6))
    total[np.ix_(rows, rows)] = vehicle.mass_matrix[np.ix_(rows, rows)]
    diagonal = np.diag(total)
    along, about = diagonal[ALONG][diagonal[ALONG] > 0.0], diagonal[ABOUT][diagonal[ABOUT] > 0.0]
    body = np.zeros(6)
    body[ALONG] = along.min(initial=np.inf) if mass is None else mass
    body[ABOUT] = about.min(initial=np.inf) if inertia is None else inertia
    if mass is None and inertia is None:
        # The largest part of such a body that leaves an added mass without negative energies.
        scale = 1.0 / np.sqrt(body[rows])
        body *= min(1.0, float(np.linalg.eigvalsh(total[np.ix_(rows, rows)] * np.outer(scale, scale))[0]))
    added = total.copy()
    added[rows, rows] -= body[rows]
    for row in rows:
        if added[row, row] < -1e-9 * total[row, row]:
            raise BadInput(
                f"the body alone has {body[row]:g} along {list(AXES)[row]}, and body and water together "
                f"{total[row, row]:.6g}; give less with --dry-mass, --dry-inertia and --inertia-xy"
            )
    return RigidBody(
        float(body[0]) if np.isfinite(body[0]) else None,
        body[ABOUT] if np.isfinite(body[ABOUT]).all() else None,
        added,
        mass is not None and inertia is not None,
    )
