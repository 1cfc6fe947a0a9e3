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
from incsvr.plant.mass_and_coriolis import coriolis_force
from incsvr.vehicle.motion import WholeMotion
from incsvr.vehicle.structure import Structure
from incsvr.vehicle.terms import LINEAR, QUADRATIC

MAX_STEP_DAMPING = 1.0
"""Largest product of a step and the rate of decay of a velocity: the method errs by less than 1 % of a step."""
MAX_SUBSTEPS = 8
"""Steps of a cell at most: a model that decays faster is clipped, and fits badly."""
RUNAWAY = 5.0
"""Velocities beyond this multiple of the largest recorded one are clipped: such a model is refused by its error."""


@dataclass(frozen=True, slots=True)
class Drive:
    """What drives the models over one motion.

    Attributes:
        motion: the recorded motion.
        structure: what the parameters mean.
        parameters: (models, size).
        effort: (models or 1, n, 6).
        mass: (models, 6, 6).
        inverse: (models, axes, axes) of the simulated part of M.
        limit: (6,) beyond which velocities are clipped.
    """

    motion: WholeMotion
    structure: Structure
    parameters: Array
    effort: Array
    mass: Array
    inverse: Array
    limit: Array

    @staticmethod
    def of(structure: Structure, parameters: Array, motion: WholeMotion) -> Drive:
        """For parameters (models, size)."""
        mass = structure.mass_matrix(parameters)
        rows = structure.rows
        inverse = np.asarray(np.linalg.inv(mass[:, rows][:, :, rows]), dtype=np.float64)
        limit = RUNAWAY * np.abs(motion.velocity).max(axis=0) + 1e-9
        return Drive(motion, structure, parameters, structure.efforts(parameters, motion), mass, inverse, limit)

    def acceleration(self, velocity: Array, effort: Array, angle: Array) -> Array:
        """ν̇ of the simulated axes (models, windows, axes) at ν (models, windows, 6)."""
        force = effort - coriolis_force(self.mass, velocity)
        coefficients = self.structure.coefficients(self.parameters)
        for k, term in enumerate(self.structure.terms):
            force[..., term.row] -= coefficients[:, k, None] * term.value(velocity, effort, angle)
        simulated = force[..., self.structure.rows]
        return np.asarray(np.einsum("bij,bnj->bni", self.inverse, simulated))

    def substeps(self) -> int:
        """Into how many steps a cell is divided, so that no velocity decays too fast."""
        rate = decay(self.structure, self.parameters, self.inverse, np.abs(self.motion.velocity).max(axis=0))
        return int(np.clip(np.ceil(self.motion.step * rate / MAX_STEP_DAMPING), 1, MAX_SUBSTEPS))


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


def simulate(
    structure: Structure, parameters: Array, motion: WholeMotion, first: NDArray[np.intp], cells: int
) -> Array:
    """ν at the edges of the windows' cells, (cells + 1, models, windows, 6).

    Args:
        parameters: (models, size).
        first: (windows,) first cells, where each window begins with the measured velocities.
        cells: length of the windows.
    """
    drive = Drive.of(structure, parameters, motion)
    rows = structure.rows
    course = np.empty((cells + 1, parameters.shape[0], first.size, 6))
    course[0] = velocity = np.repeat(motion.velocity[first][None], parameters.shape[0], axis=0)
    angle = np.repeat(motion.angle[first][None, :, :2], parameters.shape[0], axis=0)
    divide = drive.substeps()
    step = motion.step / divide
    for cell in range(cells):
        given = _Given.of(motion, structure, first + cell)
        effort = drive.effort[:, first + cell]
        for part in range(divide):
            begin, middle, end = (given.at((part + share) / divide) for share in (0.0, 0.5, 1.0))
            slopes = []
            at, tilted, place = velocity, angle, begin
            for ahead, following in ((0.5, middle), (0.5, middle), (1.0, end), (1.0, end)):
                force = drive.acceleration(place(at), effort, given.tilt(tilted))
                turn = _turning(tilted, at) if given.turning else 0.0
                slopes.append((force, turn))
                at, place = velocity.copy(), following
                at[..., rows] += ahead * step * force
                tilted = angle + ahead * step * turn if given.turning else angle
            weights = (1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0)
            velocity = velocity.copy()
            velocity[..., rows] += step * sum(w * force for w, (force, _) in zip(weights, slopes, strict=True))
            velocity = np.clip(np.nan_to_num(end(velocity)), -drive.limit, drive.limit)
            if given.turning:
                angle = angle + step * sum(w * turn for w, (_, turn) in zip(weights, slopes, strict=True))
        course[cell + 1] = velocity
    return course


@dataclass(frozen=True, slots=True)
class _Given:
    """What is taken as it was measured during one cell: velocities that are not simulated, and angles without them.

    Attributes:
        columns: places in ν of the velocities that are not simulated.
        now, next: (windows, 6) measured velocities at both ends of the cell.
        angle: (windows, 2) measured roll and pitch.
        turning: whether roll or pitch are simulated.
    """

    columns: list[int]
    now: Array
    next: Array
    angle: Array
    turning: bool

    @staticmethod
    def of(motion: WholeMotion, structure: Structure, cells: NDArray[np.intp]) -> _Given:
        """During these cells, one a window."""
        following = np.minimum(cells + 1, motion.velocity.shape[0] - 1)
        columns = [k for k in range(6) if k not in structure.rows]
        turning = "roll" in structure.axes or "pitch" in structure.axes
        return _Given(columns, motion.velocity[cells], motion.velocity[following], motion.angle[cells, :2], turning)

    def at(self, share: float) -> Callable[[Array], Array]:
        """Puts the measured velocities at a part of the cell into ν (models, windows, 6)."""
        if not self.columns:
            return lambda velocity: velocity
        measured = ((1.0 - share) * self.now + share * self.next)[:, self.columns]

        def put(velocity: Array) -> Array:
            velocity = velocity.copy()
            velocity[..., self.columns] = measured
            return velocity

        return put

    def tilt(self, angle: Array) -> Array:
        """Roll and pitch: simulated, or as measured."""
        return angle if self.turning else self.angle[None]


def _turning(angle: Array, velocity: Array) -> Array:
    """Rates of roll and pitch at the body's angular velocities (Fossen 2011, Eq. 2.26)."""
    roll, pitch = angle[..., 0], angle[..., 1]
    p, q, r = velocity[..., 3], velocity[..., 4], velocity[..., 5]
    swept = q * np.sin(roll) + r * np.cos(roll)
    return np.stack([p + swept * np.tan(pitch), q * np.cos(roll) - r * np.sin(roll)], axis=-1)
