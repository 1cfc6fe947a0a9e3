"""Simulation of a whole vehicle over many windows and for many models at once.

M ν̇ = τ − C(ν) ν − Σ c φ(ν, τ, η), with J(η) for roll and pitch, by the Runge–Kutta method of fourth order, its steps
divided where the damping is quick.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array
from incsvr.plant.axes import AXES
from incsvr.plant.terms import LINEAR, QUADRATIC
from incsvr.vehicle.forces import Forces
from incsvr.vehicle.motion import WholeMotion
from incsvr.vehicle.structure import Structure

MAX_STEP_DAMPING = 1.0
"""Largest product of a step and the rate of decay of a velocity: the method errs by less than 1 % of a step."""
MAX_SUBSTEPS = 8
"""Steps of a cell at most: a model that decays faster is clipped, and fits badly."""
RUNAWAY = 5.0
"""Velocities beyond this multiple of the largest recorded one are clipped: such a model is refused by its error."""


def simulate(
    structure: Structure, parameters: Array, motion: WholeMotion, first: NDArray[np.intp], cells: int
) -> Array:
    """ν at the edges of the windows' cells, (cells + 1, models, windows, 6).

    Args:
        parameters: (models, size).
        first: (windows,) first cells, where each window begins with the measured velocities.
        cells: length of the windows.
    """
    forces, efforts = Forces.of(structure, parameters), structure.efforts(parameters, motion)
    axes, limit = len(structure.axes), limits(structure, motion)
    state = np.repeat(first_state(structure, motion, first)[None], parameters.shape[0], axis=0)
    course = np.empty((cells + 1, parameters.shape[0], first.size, 6))
    course[:] = np.stack([motion.velocity[first + cell] for cell in range(cells + 1)])[:, None]
    divide = substeps(structure, parameters, forces.inverse, motion)
    for cell in range(cells):
        given = Cell.of(structure, forces, motion, efforts, first + cell)
        for part in range(divide):
            (state,) = runge_kutta((state,), given.rates, part, divide, motion.step)
            # What is no number becomes the lower limit, too.
            np.fmin(np.fmax(state[:, :axes], -limit), limit, out=state[:, :axes])
        course[cell + 1][..., structure.rows] = state[:, :axes].swapaxes(1, 2)
    return course


def runge_kutta(
    state: tuple[Array, ...],
    rates: Callable[[float, tuple[Array, ...]], tuple[Array, ...]],
    part: int,
    divide: int,
    cell_s: float,
) -> tuple[Array, ...]:
    """The state after one part of a cell, by the method of fourth order.

    Args:
        rates: of the state, at a share of the cell.
        part, divide: which part, of how many.
        cell_s: length of the cell [s].
    """
    step = cell_s / divide

    def ahead(slope: tuple[Array, ...], length: float) -> tuple[Array, ...]:
        return tuple(each + length * rise for each, rise in zip(state, slope, strict=True))

    begin, middle, end = ((part + share) / divide for share in (0.0, 0.5, 1.0))
    one = rates(begin, state)
    two = rates(middle, ahead(one, 0.5 * step))
    three = rates(middle, ahead(two, 0.5 * step))
    four = rates(end, ahead(three, step))
    return ahead(tuple((a + d + 2.0 * (b + c)) / 6.0 for a, b, c, d in zip(one, two, three, four, strict=True)), step)


def first_state(structure: Structure, motion: WholeMotion, first: NDArray[np.intp]) -> Array:
    """(states, windows): the velocities of the simulated axes in their order, and roll and pitch where they turn."""
    velocity = motion.velocity[first][:, structure.rows]
    return np.concatenate((velocity, motion.angle[first, :2]), axis=1).T if turns(structure) else velocity.T


def turns(structure: Structure) -> bool:
    """Whether roll and pitch are simulated."""
    return "roll" in structure.axes or "pitch" in structure.axes


def limits(structure: Structure, motion: WholeMotion) -> Array:
    """(axes, 1) velocities of the simulated axes beyond which a simulation is clipped."""
    return np.asarray(RUNAWAY * np.abs(motion.velocity[:, structure.rows]).max(axis=0)[:, None] + 1e-9)


def substeps(structure: Structure, parameters: Array, inverse: Array, motion: WholeMotion) -> int:
    """Into how many steps a cell is divided, so that no velocity decays too fast; arguments as of `decay`."""
    rate = decay(structure, parameters, inverse, np.abs(motion.velocity).max(axis=0))
    return int(np.clip(np.ceil(motion.step * rate / MAX_STEP_DAMPING), 1, MAX_SUBSTEPS))


def decay(structure: Structure, parameters: Array, inverse: Array, fastest: Array) -> float:
    """The largest rate at which a velocity of any of the models decays [1/s].

    Args:
        parameters: (models, size).
        inverse: (models, axes, axes) of the simulated part of M.
        fastest: (6,) fastest velocities.
    """
    coefficients = structure.coefficients(parameters)
    slope = np.zeros((parameters.shape[0], 6))
    for k, term in enumerate(structure.terms):
        if term.kind == LINEAR:
            slope[:, term.row] += np.abs(coefficients[:, k])
        elif term.kind == QUADRATIC:
            slope[:, term.row] += 2.0 * np.abs(coefficients[:, k]) * fastest[term.row]
    rate = slope[:, structure.rows] * np.einsum("bii->bi", inverse)
    return float(rate.max(initial=0.0))


@dataclass(frozen=True, slots=True)
class Cell:
    """The inputs of the models during one cell of each window.

    Attributes:
        forces: of the models.
        rows, columns: places in ν of the velocities that are simulated, and of the others.
        now, following: (columns, windows) the others' measured velocities at both ends of the cell.
        effort: (models or 1, 6, windows) means over the cell.
        rise: (6, windows) by how much the efforts rise over the cell.
        angle: (2, windows) measured roll and pitch, which hold where they are not simulated.
        turning: whether they are simulated.
    """

    forces: Forces
    rows: list[int]
    columns: list[int]
    now: Array
    following: Array
    effort: Array
    rise: Array
    angle: Array
    turning: bool

    @staticmethod
    def of(structure: Structure, forces: Forces, motion: WholeMotion, efforts: Array, cells: NDArray[np.intp]) -> Cell:
        """During these cells, one a window; `efforts` are those of the models, (models or 1, n, 6)."""
        following = np.minimum(cells + 1, motion.velocity.shape[0] - 1)
        columns = [k for k in range(6) if k not in structure.rows]
        now, then = (motion.velocity[place][:, columns].T for place in (cells, following))
        effort, rise = efforts[:, cells].swapaxes(1, 2), motion.effort_rise[cells].T.copy()
        rise[[list(AXES).index(name) for name in structure.lags]] = 0.0  # a lag makes them smooth
        angle = motion.angle[cells, :2].T
        return Cell(forces, structure.rows, columns, now, then, effort, rise, angle, turns(structure))

    def at(self, share: float, state: Array) -> tuple[Array, Array]:
        """ν (models, 6, windows) and roll and pitch (models or 1, 2, windows) of states (models, states, windows) at a
        part of the cell."""
        axes = len(self.rows)
        angle = state[:, axes:] if self.turning else self.angle[None]
        if not self.columns:
            return state[:, :axes], angle
        velocity = np.empty((state.shape[0], 6, state.shape[2]))
        velocity[:, self.rows] = state[:, :axes]
        velocity[:, self.columns] = (1.0 - share) * self.now + share * self.following
        return velocity, angle

    def rate(self, share: float, state: Array) -> Array:
        """The rates of states (models, states, windows) at a part of the cell."""
        velocity, angle = self.at(share, state)
        found = self.forces.acceleration(velocity, self.effort_at(share), angle)
        return np.concatenate((found, _turning(angle, velocity)), axis=1) if self.turning else found

    def effort_at(self, share: float) -> Array:
        """τ (models or 1, 6, windows) at a part of the cell."""
        return self.effort + (share - 0.5) * self.rise

    def rates(self, share: float, state: tuple[Array, ...]) -> tuple[Array, ...]:
        """`rate` of a state that stands alone."""
        return (self.rate(share, state[0]),)


def _turning(angle: Array, velocity: Array) -> Array:
    """Rates of roll and pitch (models, 2, windows) at the body's angular velocities (Fossen 2011, Eq. 2.26)."""
    roll, pitch = angle[:, 0], angle[:, 1]
    p, q, r = velocity[:, 3], velocity[:, 4], velocity[:, 5]
    sin, cos = np.sin(roll), np.cos(roll)
    return np.stack([p + (q * sin + r * cos) * np.tan(pitch), q * cos - r * sin], axis=1)
