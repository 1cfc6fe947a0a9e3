"""The derivative of the simulated velocities of windows by each parameter: the tangent of the simulation.

ṡ = (∂ν̇/∂ν) s + ∂ν̇/∂c, by the same Runge–Kutta steps, with ∂ν̇/∂ν by differences of one model's states. So all
slopes of a model with a hundred parameters cost as much as some ten simulations.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array
from incsvr.vehicle.forces import Forces, unit_masses
from incsvr.vehicle.motion import WholeMotion
from incsvr.vehicle.simulation import Cell, first_state, limits, runge_kutta, substeps
from incsvr.vehicle.structure import Structure

RELATIVE_STEP = 1e-6
"""Step of the differences along a state, in its limit (an angle's in rad): forces are of second order in the states."""


def sensitivities(
    structure: Structure,
    parameters: Array,
    lag_shift: Array,
    motion: WholeMotion,
    first: NDArray[np.intp],
    cells: int,
) -> Array:
    """∂ν/∂parameter of the simulated axes, (size, windows, cells, axes).

    Args:
        parameters: (size,).
        lag_shift: (lags,) steps of the differences along time constants [s].
        motion, first, cells: as of `simulate`.
    """
    tangent = _Tangent.of(structure, parameters, lag_shift, motion)
    axes, limit = len(structure.axes), limits(structure, motion)
    state = first_state(structure, motion, first)[None]
    slope = np.zeros((first.size, state.shape[1], structure.size))
    found = np.empty((cells, first.size, axes, structure.size))
    divide = substeps(structure, parameters[None], tangent.forces.inverse, motion)
    for cell in range(cells):
        given = Cell.of(structure, tangent.forces, motion, tangent.efforts, first + cell)
        for part in range(divide):
            state, slope = runge_kutta((state, slope), partial(tangent.rates, given), part, divide, motion.step)
            runaway = ~(np.abs(state[0, :axes]) < limit)
            if runaway.any():  # a velocity that is clipped moves with nothing
                np.fmin(np.fmax(state[:, :axes], -limit), limit, out=state[:, :axes])
                slope[:, :axes][runaway.T] = 0.0
        found[cell] = slope[:, :axes]
    return np.ascontiguousarray(found.transpose(3, 1, 0, 2))


@dataclass(frozen=True, slots=True)
class _Tangent:
    """The matrices of the tangent of one model's motion.

    Attributes:
        structure: what the parameters mean.
        forces: of the model.
        efforts: (1 + states + lags, n, 6) of the model, of the model with each state moved, and with each lag moved.
        moved: (1 + states + lags, states) by how much each is moved.
        step: (states,) of the differences.
        lag_shift: (lags,) by how much each lag is moved [s].
        of_mass: (masses · axes, products + axes) ∂ν̇/∂M from the products of forces and ν̇.
        of_term: (axes, terms) ∂ν̇/∂c for each unit of the term's product.
    """

    structure: Structure
    forces: Forces
    efforts: Array
    moved: Array
    step: Array
    lag_shift: Array
    of_mass: Array
    of_term: Array

    @staticmethod
    def of(structure: Structure, parameters: Array, lag_shift: Array, motion: WholeMotion) -> _Tangent:
        """The tangent of a model with parameters (size,); other arguments as of `sensitivities`."""
        forces, rows = Forces.of(structure, parameters[None]), structure.rows
        inverse = forces.inverse[0]
        states = first_state(structure, motion, np.zeros(1, dtype=np.intp)).shape[0]
        step = RELATIVE_STEP * np.append(limits(structure, motion)[:, 0], np.ones(states - len(rows)))
        lags = structure.size - lag_shift.size + np.arange(lag_shift.size)
        models = np.repeat(parameters[None], 1 + states + lag_shift.size, axis=0)
        models[1 + states + np.arange(lag_shift.size), lags] += lag_shift
        moved = np.zeros((models.shape[0], states))
        moved[1 : 1 + states] = np.diag(step)
        masses = -inverse @ np.concatenate((forces.turned, unit_masses(structure)[:, rows][:, :, rows]), axis=2)
        of_term = -inverse[:, [rows.index(term.row) for term in structure.terms]] * forces.sign
        efforts = structure.efforts(models, motion)
        return _Tangent(
            structure, forces, efforts, moved, step, lag_shift, masses.reshape(-1, masses.shape[-1]), of_term
        )

    def rates(self, given: Cell, share: float, at: tuple[Array, ...]) -> tuple[Array, ...]:
        """Rates of the state (1, states, windows) and of its slopes (windows, states, size) at a share of a cell."""
        state, slope = at
        states, axes = state.shape[1], len(self.structure.axes)
        masses, terms = len(self.structure.mass), len(self.structure.terms)
        rates = given.rate(share, state + self.moved[:, :, None])
        along = (rates[1 : 1 + states] - rates[:1]) / self.step[:, None, None]
        rise = along.transpose(2, 1, 0) @ slope
        velocity, angle = given.at(share, state)
        product = self.forces.products(velocity, given.effort_at(share)[:1], angle)[0]
        of_mass = self.of_mass @ np.concatenate((product, rates[0, :axes]))
        rise[:, :axes, :masses] += of_mass.reshape(masses, axes, state.shape[2]).transpose(2, 1, 0)
        rise[:, :axes, masses : masses + terms] += product[self.forces.term].T[:, None] * self.of_term
        of_lag = (rates[1 + states :] - rates[:1]) / self.lag_shift[:, None, None]
        rise[:, :, masses + terms :] += of_lag.transpose(2, 1, 0)
        return rates[:1], rise
