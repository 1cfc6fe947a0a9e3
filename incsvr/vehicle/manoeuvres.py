"""The manoeuvres that would excite the parameters which recordings do not show: one sentence a parameter."""

from __future__ import annotations

from incsvr.vehicle.model import ASSUMED, UNKNOWN, Vehicle
from incsvr.vehicle.terms import LINEAR, QUADRATIC


def manoeuvres(vehicle: Vehicle) -> tuple[str, ...]:
    """The manoeuvres for the parameters that are not excited."""
    found: list[str] = []
    for (one, other), parameter in vehicle.mass.items():
        if parameter.origin == UNKNOWN:
            what = f"the {one} inertia" if one == other else f"the inertia that couples {one} and {other}"
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
