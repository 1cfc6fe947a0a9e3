"""A vehicle file's model of a simulated body."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.plant.axes import AXES
from incsvr.plant.terms import Term
from incsvr.vehicle import Parameter, Vehicle
from simulator.vehicles import NAMES
from simulator.vehicles import Vehicle as Body

FASTEST = (1.0, 0.85, 0.85, 2.1, 3.2, 2.7)
"""How fast the small ROV goes under its largest efforts [m/s], [rad/s]."""


def own_damping(axes: Sequence[str]) -> tuple[Term, ...]:
    """Linear and quadratic damping of each axis."""
    return tuple(Term(name, kind) for name in AXES if name in axes for kind in ("linear", "quadratic"))


def vehicle_of(body: Body, fastest: Sequence[float] = FASTEST) -> Vehicle:
    """The model of a body that goes so fast [m/s], [rad/s], its numbers as they are."""

    def known(value: float) -> Parameter:
        return Parameter(value, value, value)

    places = {name: NAMES.index(name) for name in body.moves}
    mass = {(a, b): known(float(body.mass[i, j])) for a, i in places.items() for b, j in places.items()
            if i <= j and body.mass[i, j] != 0.0}  # fmt: skip
    own = {"linear": body.linear, "quadratic": body.quadratic, "righting": np.full(6, body.righting)}
    righted = [Term(name, "righting") for name in ("roll", "pitch") if name in body.moves and body.righting]
    terms = (*own_damping(body.moves), *righted)
    found = {term: known(float(own[term.kind][places[term.axis]])) for term in terms}
    return Vehicle("rov", body.moves, tuple(body.effort), mass, found, {}, np.array(fastest))
