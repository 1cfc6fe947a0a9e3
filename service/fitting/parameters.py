"""Every parameter of a vehicle's model with its name and unit: the rows of its text, its table and its CSV."""

from __future__ import annotations

from collections.abc import Iterator

from incsvr.plant.terms import mass_unit, stage_unit, thrust_name
from incsvr.vehicle import Parameter, Vehicle


def parameters(vehicle: Vehicle) -> Iterator[tuple[tuple[str, str], str, str, Parameter]]:
    """The axis, twice but for an inertia that couples two; the name; the unit; the value with its interval."""
    for pair, p in vehicle.mass.items():
        yield pair, "inertia", mass_unit(*pair), p
    for term, p in vehicle.terms.items():
        yield (term.axis, term.axis), term.name, term.unit, p
    for axis, p in vehicle.lags.items():
        yield (axis, axis), "thrust lag", "s", p
    for axis, of in vehicle.thrust.items():
        for name, p in of.items():
            yield (axis, axis), thrust_name(name), stage_unit(axis, name), p
