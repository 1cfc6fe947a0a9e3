"""The learners of a vehicle: for each axis with an actuator the plain sections that `identify` writes in its file."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning.iteration import scaled_to
from incsvr.numerics import Array
from incsvr.plant.attitude import ATTITUDE
from incsvr.plant.axes import AXES
from incsvr.plant.body import Coupled
from service.config.configuration import validate

if TYPE_CHECKING:
    from incsvr.vehicle import Vehicle

RATE_LIMIT_FACTOR = 3.0
"""A velocity beyond so many times the fastest one of the file's data is no measurement."""
MAX_RATE_LIMIT = 50.0
"""The largest rate limit that the configuration takes [rad/s], [m/s]."""
MAX_TORQUE_LIMIT = 1e7
"""The largest torque limit that the configuration takes [N m], [N]."""
EFFORT_LIMIT_FACTOR = 20.0
"""An effort beyond so many times the damping at the fastest velocity is no measurement: one in another unit is."""
SLOWEST_DECAY_S = 10.0
"""A damping that was found to be next to nothing counts as one by which the velocity decays in this time [s]."""
SCALED = ("gamma", "C", "epsilon", "near_rate", "near_damping")
"""The settings of a learner that have the units of its axis."""
GRAVITY = 9.81
"""[m/s²]"""


def learners_of(vehicle: Vehicle) -> dict[str, dict[str, Any]]:
    """The section `learners` of a vehicle, that of yaw first: `inputs` in others' forms describe the first one."""
    names = sorted(vehicle.driven, key=lambda name: name != "yaw")
    predicted = [name in vehicle.axes for name in AXES]
    mass = np.where(np.outer(predicted, predicted), vehicle.mass_matrix, 0.0)
    return {name: _learner(vehicle, mass, name) for name in names}


def body_of(vehicle: Vehicle, axis: str) -> dict[str, Any]:
    """The mass matrix, the weight, the buoyancy and the centre of gravity that a vehicle declares for an axis.

    Raises:
        BadInput: it has no actuator along this axis.
    """
    learners = learners_of(vehicle)
    if axis not in learners:
        raise BadInput(
            f"{vehicle.name}: it has no actuator along {axis}, but along {', '.join(learners)}; choose one with --axis"
        )
    names = ("mass_matrix", "weight", "buoyancy", "centre_of_gravity")
    return {name: value for name, value in learners[axis]["vehicle"].items() if name in names}


def _learner(vehicle: Vehicle, mass: Array, axis: str) -> dict[str, Any]:
    place = list(AXES).index(axis)
    fastest = float(f"{vehicle.fastest[place]:.3g}")
    terms = {term.name: parameter.value for term, parameter in vehicle.terms.items() if term.axis == axis}
    least = mass[place, place] * fastest / SLOWEST_DECAY_S
    damping = max(terms.get("linear", 0.0) * fastest + terms.get("quadratic", 0.0) * fastest**2, float(least))
    section = {
        "name": re.sub(r"[^A-Za-z0-9_.-]+", "-", vehicle.name)[:64],
        "axis": axis,
        "mass_matrix": mass.ravel().tolist(),
        "rate_range": [-fastest, fastest],
        "rate_limit": min(float(f"{RATE_LIMIT_FACTOR * fastest:.3g}"), MAX_RATE_LIMIT),
        "torque_limit": min(float(f"{EFFORT_LIMIT_FACTOR * damping:.3g}"), MAX_TORQUE_LIMIT),
        **_weights(mass, axis, terms.get("weight" if axis == "heave" else "righting", 0.0)),
    }
    recorded = (*(AXES[name].rate for name in vehicle.axes), *ATTITUDE)
    coupled = Coupled(AXES[axis], mass, recorded, validate({"vehicle": section}, {}).vehicle.restoring)
    settings = scaled_to(fastest, damping)
    return {
        "vehicle": section,
        "learner": {name: float(f"{getattr(settings, name):.3g}") for name in SCALED},
        "signals": {"channels": list(coupled.streams)},
    }


def _weights(mass: Array, axis: str, term: float) -> dict[str, Any]:
    """Weight, buoyancy and centre of gravity that make the vehicle's restoring term of this axis.

    The term gives W − B (heave) or z_g W (roll, pitch) alone. With the centre of buoyancy at the origin, and B = W
    but for heave, the force is the term's whatever W is: it is taken for that of the mass along surge or heave.
    """
    if not term:
        return {}
    weight = max(GRAVITY * float(mass[0, 0]), GRAVITY * float(mass[2, 2]), 2.0 * abs(term))
    if axis == "heave":
        return {"weight": weight, "buoyancy": weight - term}
    return {"weight": weight, "centre_of_gravity": [0.0, 0.0, term / weight]}
