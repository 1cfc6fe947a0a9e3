"""The remarks on an exported whole vehicle: its range, its guesses, and the parts left out."""

from __future__ import annotations

from collections.abc import Callable

from incsvr.plant.axes import AXES
from incsvr.plant.terms import RIGHTING, WEIGHT, Term
from incsvr.vehicle import Vehicle
from incsvr.vehicle.model import ASSUMED, BOUND_REACHED, UNKNOWN
from service.export.rigid_body import RigidBody

STANDARD_GRAVITY = 9.80665
"""[m/s²]."""


def vehicle_remarks(vehicle: Vehicle, body: RigidBody, holds: Callable[[Term], bool], flu: bool) -> list[str]:
    """The remarks on the elements, as sentences."""
    fastest = ", ".join(
        f"{n} {v:.3g}" for n, v in zip(AXES, vehicle.fastest.tolist(), strict=True) if n in vehicle.axes
    )
    missing = [name for name in AXES if name not in vehicle.axes]
    lost = [
        f"{t.axis} {t.name} = {p.value:.4g} {t.unit}"
        for t, p in vehicle.terms.items()
        if not holds(t) and t.kind not in (RIGHTING, WEIGHT)
    ]
    found = [f"{vehicle.name}, identified by incsvr up to {fastest} (m/s, rad/s); beyond, it is a guess."]
    if missing:
        found.append(f"Not identified, and 0 here: added mass and damping of {', '.join(missing)}; put in your own.")
    found += doubts(vehicle)
    if lost:
        found.append(f"This format cannot hold: {'; '.join(lost)}.")
    part = "as declared" if body.declared else "the largest that body and water together admit"
    cure = "" if body.declared else "; --dry-mass, --dry-inertia and --inertia-xy declare it"
    found.append(
        f"The dives show only the sum of body and water. The body's part is {part}{cure}. The rest is added mass."
    )
    if body.guessed:
        found.append("The body's moments about the axes that are not identified are guesses.")
    return [*found, *_hydrostatics(vehicle, body, flu)]


def doubts(vehicle: Vehicle) -> list[str]:
    """The parameters that the dives do not show, and what else is doubted, as sentences."""
    named = {f"{t.axis} {t.name}": p for t, p in vehicle.terms.items()}
    named |= {f"{a} inertia" if a == b else f"{a}-{b} inertia": p for (a, b), p in vehicle.mass.items()}
    unsure = [f"{name} ({p.origin})" for name, p in named.items() if p.origin in (UNKNOWN, BOUND_REACHED, ASSUMED)]
    found = [f"The dives do not show: {', '.join(unsure)}."] if unsure else []
    return [*found, *(f"Doubt: {each}." for each in vehicle.doubts)]


def _hydrostatics(vehicle: Vehicle, body: RigidBody, flu: bool) -> list[str]:
    """The places of weight and buoyancy for the identified restoring moments."""
    found = []
    for term, p in vehicle.terms.items():
        if term.kind == RIGHTING:
            height = "" if body.mass is None else f", {p.value / (body.mass * STANDARD_GRAVITY):.4g} m for this mass"
            found.append(
                f"Righting moment of {term.axis}: {p.value:.4g} N m = weight times the height of the centre of "
                f"buoyancy above the centre of mass{height}."
            )
        elif term.kind == WEIGHT:
            found.append(f"Weight less buoyancy: {-p.value if flu else p.value:.4g} N; choose the volume so.")
    return found
