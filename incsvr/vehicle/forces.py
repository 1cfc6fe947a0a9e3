"""The forces on a vehicle as weighted products of two quantities each, as a simulation evaluates them.

Every term of the equations, and every Coriolis force, is a product of two of: one, velocities, their sizes, efforts,
reverse efforts, and the directions of roll and pitch. So the acceleration is one matrix times the products that occur.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array
from incsvr.plant.axes import AXES, VELOCITIES
from incsvr.plant.mass_and_coriolis import PAIRS, product_weights
from incsvr.plant.terms import Term
from incsvr.vehicle.structure import Structure

ONE, VELOCITY, SIZE, PUSH, BACKWARD, DOWN, HEEL, QUANTITIES = 0, 1, 7, 13, 19, 25, 28, 30
"""Places of the quantities: one, ν, |ν|, τ, τ where it is negative (six each), the downward direction (three), what
righting moments are proportional to (two); and how many there are."""


def quantities(velocity: Array, effort: Array, angle: Array | None) -> Array:
    """(models, QUANTITIES, n) from ν and τ (models, 6, n), and roll and pitch (models, 2, n); without these the
    quantities that follow from them are left undefined."""
    found = np.empty((velocity.shape[0], QUANTITIES, velocity.shape[2]))
    found[:, ONE] = 1.0
    found[:, VELOCITY:SIZE] = velocity
    np.abs(velocity, out=found[:, SIZE:PUSH])
    found[:, PUSH:BACKWARD] = effort
    np.minimum(found[:, PUSH:BACKWARD], 0.0, out=found[:, BACKWARD:DOWN])
    if angle is None:
        return found
    (roll, pitch), (cos_roll, cos_pitch) = np.sin(angle).swapaxes(0, 1), np.cos(angle).swapaxes(0, 1)
    found[:, DOWN] = -pitch
    found[:, DOWN + 1] = found[:, HEEL] = cos_pitch * roll
    found[:, DOWN + 2] = cos_pitch * cos_roll
    found[:, HEEL + 1] = pitch
    return found


def factors(term: Term) -> tuple[int, int, float]:
    """Places of the two quantities whose product is φ, and its sign."""
    own = term.row
    of = [VELOCITIES.index(name) for name in term.of if name in VELOCITIES]
    match term.kind:
        case "linear":
            return ONE, VELOCITY + own, 1.0
        case "quadratic":
            return VELOCITY + own, SIZE + own, 1.0
        case "cross":
            return ONE, VELOCITY + of[0], 1.0
        case "cross_size":
            return VELOCITY + of[1], SIZE + of[0], 1.0
        case "effort":
            return ONE, PUSH + list(AXES).index(term.of[0]), -1.0
        case "inflow":
            return SIZE + of[0], PUSH + own, 1.0
        case "reverse":
            return ONE, BACKWARD + own, 1.0
        case "weight":
            return ONE, DOWN + own, -1.0
        case "righting":
            return ONE, HEEL + own - 3, 1.0
        case "bias":
            return ONE, ONE, 1.0
        case _:  # a product, or a square
            low, high = sorted((of[0], of[-1]))
            return VELOCITY + low, VELOCITY + high, 1.0


@dataclass(frozen=True, slots=True)
class Forces:
    """The forces of models of one structure.

    Attributes:
        left, right: (products,) places of the quantities of each product.
        weights: (models, axes, products) by which the products become ν̇ of the simulated axes.
        inverse: (models, axes, axes) of the simulated part of M.
        term: (terms,) place of each term's product.
        sign: (terms,) of each term's product in φ.
        turned: (entries, axes, products) the Coriolis forces of a unit of each estimated entry of M.
        tilts: whether any product depends on roll or pitch.
    """

    left: NDArray[np.intp]
    right: NDArray[np.intp]
    weights: Array
    inverse: Array
    term: NDArray[np.intp]
    sign: Array
    turned: Array
    tilts: bool

    @staticmethod
    def of(structure: Structure, parameters: Array) -> Forces:
        """The forces of parameters (models, size)."""
        rows, mass = structure.rows, structure.mass_matrix(parameters)
        inverse = np.asarray(np.linalg.inv(mass[:, rows][:, :, rows]), dtype=np.float64)
        coriolis, units = product_weights(mass)[:, rows], product_weights(unit_masses(structure))[:, rows]
        pairs = np.flatnonzero(np.any(np.concatenate((coriolis, units)) != 0.0, axis=(0, 1)))
        places = {(VELOCITY + a, VELOCITY + b): k for k, (a, b) in enumerate(np.array(PAIRS)[pairs].tolist())}
        pushes = [places.setdefault((ONE, PUSH + row), len(places)) for row in rows]
        found = [factors(term) for term in structure.terms]
        term = [places.setdefault((left, right), len(places)) for left, right, _ in found]
        sign = np.array([each[2] for each in found])
        force = np.zeros((parameters.shape[0], len(rows), len(places)))
        force[:, :, : pairs.size] = -coriolis[:, :, pairs]
        force[:, range(len(rows)), pushes] += 1.0
        coefficients = structure.coefficients(parameters)
        for k, each in enumerate(structure.terms):
            force[:, rows.index(each.row), term[k]] -= sign[k] * coefficients[:, k]
        turned = np.zeros((units.shape[0], len(rows), len(places)))
        turned[:, :, : pairs.size] = units[:, :, pairs]
        left, right = np.array(list(places), dtype=np.intp).reshape(-1, 2).T
        tilts = bool(np.any(right >= DOWN))
        return Forces(left, right, inverse @ force, inverse, np.array(term, dtype=np.intp), sign, turned, tilts)

    def products(self, velocity: Array, effort: Array, angle: Array) -> Array:
        """(models, products, n); arguments as of `quantities`."""
        each = quantities(velocity, effort, angle if self.tilts else None)
        return np.asarray(each[:, self.left] * each[:, self.right])

    def acceleration(self, velocity: Array, effort: Array, angle: Array) -> Array:
        """ν̇ of the simulated axes (models, axes, n); arguments as of `quantities`."""
        return np.asarray(self.weights @ self.products(velocity, effort, angle))


def unit_masses(structure: Structure) -> Array:
    """(entries, 6, 6) the slope of M along each estimated entry."""
    names, found = list(AXES), np.zeros((len(structure.mass), 6, 6))
    for k, (one, other) in enumerate(structure.mass):
        row, column = names.index(one), names.index(other)
        found[k, row, column] = found[k, column, row] = 1.0
    return found
