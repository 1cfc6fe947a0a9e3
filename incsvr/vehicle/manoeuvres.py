"""The manoeuvres that would show what recordings do not: one sentence for each parameter or diverging free run."""

from __future__ import annotations

from incsvr.plant.axes import AXES
from incsvr.plant.terms import LINEAR, QUADRATIC, mass_unit
from incsvr.vehicle.model import ASSUMED, BOUND_REACHED, UNKNOWN, Vehicle
from incsvr.vehicle.validation import Errors


def manoeuvres(vehicle: Vehicle) -> tuple[str, ...]:
    """The manoeuvres for the parameters that the recordings do not determine."""
    found: list[str] = []
    for (one, other), parameter in vehicle.mass.items():
        what = f"the {one} inertia" if one == other else f"the inertia that couples {one} and {other}"
        if parameter.origin == BOUND_REACHED:
            found.append(
                f"the recordings do not determine {what}: its value, {parameter.value:.4g} {mass_unit(one, other)}, is "
                f"the bound of the search (bound reached); change the {one} effort in steps, faster than the vehicle "
                "settles, and record the velocities along all axes that move, or declare it with --mass-matrix"
            )
        elif parameter.origin == UNKNOWN:
            found.append(f"{what} is not excited: change the {one} effort in steps, faster than the vehicle settles")
        elif parameter.origin == ASSUMED:
            found.append(
                f"the {one} inertia is assumed, because no effort acts along {one}: declare it with --mass-matrix"
            )
    for term, parameter in vehicle.terms.items():
        if parameter.origin != UNKNOWN:
            continue
        if term.kind in (LINEAR, QUADRATIC):
            how = f"hold several {term.axis} speeds, slow and fast, to both sides"
        else:
            how = f"move along {' and '.join(term.of) or term.axis} at the same time, in several proportions"
        found.append(f"{term.axis} {term.name} is not excited: {how}")
    return tuple(dict.fromkeys(found))


def divergences(errors: Errors) -> tuple[str, ...]:
    """A sentence on each axis whose free run errs by more than a vehicle at rest would, with the cure."""
    return tuple(
        f"the free run of {axis} diverges: over whole dives it errs by {model:.3g}, a velocity of zero by {zero:.3g} "
        f"{'m/s' if AXES[axis].along else 'rad/s'}; use the model for predictions of some seconds, and record a "
        f"manoeuvre that varies the {axis} speed: steps of the effort, each held until the speed settles"
        for axis, model, zero in zip(errors.axes, errors.free_run.tolist(), errors.zero.tolist(), strict=True)
        if not model < zero
    )
