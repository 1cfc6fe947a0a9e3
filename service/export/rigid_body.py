"""The identified M parted into a rigid body and the water's added mass, as simulators want it.

A log shows only their sum, and only their sum moves the vehicle; the body's own mass decides its weight.
"""

from __future__ import annotations

import math
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
        declared: whether somebody gave the mass and the moments of what was identified.
        guessed: whether moments stand for axes that nobody identified or gave.
    """

    mass: float | None
    inertia: Array | None
    added: Array
    declared: bool
    guessed: bool


def parted(
    vehicle: Vehicle,
    mass: float | None = None,
    about_yaw: float | None = None,
    across: tuple[float, float] | None = None,
) -> RigidBody:
    """M in two parts.

    Args:
        mass: of the body alone [kg]; None takes what the identified axes admit at most.
        about_yaw, across: moments of the body alone about yaw, and about roll and pitch [kg m²]; None likewise, the
            same about all three, and all of it about yaw where `across` is given.

    Raises:
        BadInput: what is given is no inertia, or more than that of body and water together.
    """
    for value in (mass, about_yaw, *(across or ())):
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise BadInput(f"{value:g} is no moment of inertia; give a positive number in kg m² (a mass in kg)")
    if (about_yaw is None) != (across is None) and {"roll", "pitch"} & set(vehicle.axes):
        raise BadInput("the body's moments of inertia need --dry-inertia and --inertia-xy together, for this vehicle")
    rows = vehicle.structure.rows
    total = np.zeros((6, 6))
    total[np.ix_(rows, rows)] = vehicle.mass_matrix[np.ix_(rows, rows)]
    diagonal = np.diag(total)
    along, about = diagonal[ALONG][diagonal[ALONG] > 0.0], diagonal[ABOUT][diagonal[ABOUT] > 0.0]
    body = np.zeros(6)
    body[ALONG] = along.min(initial=np.inf) if mass is None else mass
    usual = about.min(initial=np.inf) if about_yaw is None else about_yaw
    body[ABOUT] = (*((usual, usual) if across is None else across), usual)
    given = about_yaw is not None or across is not None
    if mass is None and not given:
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
    added[np.abs(added) < 1e-12 * diagonal.max()] = 0.0  # what rounding leaves of nothing
    turns = bool(np.isfinite(body[ABOUT]).all())
    return RigidBody(
        float(body[0]) if np.isfinite(body[0]) else None,
        body[ABOUT] if turns else None,
        added,
        (mass is not None or not along.size) and (given or not about.size),
        turns and across is None and about.size < 3,
    )
