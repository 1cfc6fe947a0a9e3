"""Simulation of a whole vehicle over many windows and for many models at once.

M ν̇ = τ − C(ν) ν − Σ c φ(ν, τ, η), with J(η) for roll and pitch, by steps of Heun's method (second order), divided where
the damping is quick.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array
from incsvr.vehicle.motion import WholeMotion
from incsvr.vehicle.structure import Structure

MAX_STEP_DAMPING = 0.5
"""Largest product of a step and the rate of decay of a velocity: Heun's method is stable below 2, and errs by 2 % here."""
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
        inverse = np.linalg.inv(mass[:, rows][:, :, rows])
        limit = RUNAWAY * np.abs(motion.velocity).max(axis=0) + 1e-9
        return Drive(motion, structure, parameters, structure.efforts(parameters, motion), mass, inverse, limit)

    def acceleration(self, velocity: Array, effort: Array, angle: Array) -> Array:
        """ν̇ of the simulated axes (models, windows, axes) at ν (models, windows, 6)."""
        force = effort - coriolis(self.mass, velocity)
        coefficients = self.structure.coefficients(self.parameters)
        for k, term in enumerate(self.structure.terms):
            force[..., term.row] -= coefficients[:, k, None] * term.value(velocity, effort, angle)
        simulated = force[..., self.structure.rows]
        return np.einsum("bij,bnj->bni", self.inverse, simulated)

    def substeps(self) -> int:
        """Into how many steps a cell is divided, so that no velocity decays too fast."""
        own = self.structure.terms
        coefficients = self.structure.coefficients(self.parameters)
        decay = np.zeros((self.parameters.shape[0], 6))
        fastest = np.abs(self.motion.velocity).max(axis=0)
        for k, term in enumerate(own):
            if term.kind == "linear":
                decay[:, term.row] += np.abs(coefficients[:, k])
            elif term.kind == "quadratic":
                decay[:, term.row] += 2.0 * np.abs(coefficients[:, k]) * fastest[term.row]
        rows = self.structure.rows
        rate = decay[:, rows] * np.einsum("bii->bi", self.inverse)
        return int(np.clip(np.ceil(self.motion.step * rate.max(initial=0.0) / MAX_STEP_DAMPING), 1, MAX_SUBSTEPS))


def simulate(structure: Structure, parameters: Array, motion: WholeMotion, first: NDArray[np.intp], cells: int) -> Array:
    """ν at the edges of the windows' cells, (cells + 1, models, windows, 6).

    Args:
        parameters: (models, size).
        first: (windows,) first cells, where each window begins with the measured velocities.
        cells: length of the windows.
    """
    drive = Drive.of(structure, parameters, motion)
    count, rows = parameters.shape[0], structure.rows
    given = [k for k in range(6) if k not in rows]
    turning = "roll" in structure.axes or "pitch" in structure.axes
    velocity = np.repeat(motion.velocity[first][None], count, axis=0)
    angle = np.repeat(motion.angle[first][None, :, :2], count, axis=0)
    course = np.empty((cells + 1, *velocity.shape))
    course[0] = velocity
    divide = drive.substeps()
    step = motion.step / divide
    last = motion.velocity.shape[0] - 1
    for cell in range(cells):
        effort = drive.effort[:, first + cell]
        following = np.minimum(first + cell + 1, last)
        for part in range(divide):
            share = (part + 1) / divide
            slope = drive.acceleration(velocity, effort, angle)
            ahead = velocity.copy()
            ahead[..., rows] += step * slope
            if given:
                now = (1.0 - share) * motion.velocity[first + cell] + share * motion.velocity[following]
                ahead[..., given] = now[:, given]
            tilted = _turned(angle, velocity, step) if turning else motion.angle[following][None, :, :2]
            slope = 0.5 * (slope + drive.acceleration(ahead, effort, tilted))
            velocity = velocity.copy()
            velocity[..., rows] += step * slope
            velocity[..., given] = ahead[..., given]
            velocity = np.clip(np.nan_to_num(velocity), -drive.limit, drive.limit)
            angle = _turned(angle, 0.5 * (velocity + ahead), step) if turning else tilted
        course[cell + 1] = velocity
    return course


def coriolis(mass: Array, velocity: Array) -> Array:
    """C(ν) ν (models, windows, 6) of M (models, 6, 6) and ν (models, windows, 6) (Fossen 2011, Theorem 3.2)."""
    momentum = np.einsum("bij,bnj->bni", mass, velocity)
    linear, angular = momentum[..., :3], momentum[..., 3:]
    along, about = velocity[..., :3], velocity[..., 3:]
    return np.concatenate([_cross(about, linear), _cross(along, linear) + _cross(about, angular)], axis=-1)


def _cross(a: Array, b: Array) -> Array:
    """a × b over the last axis, without the checks of numpy.cross."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def _turned(angle: Array, velocity: Array, step: float) -> Array:
    """Roll and pitch after a step at the body's angular velocities (Fossen 2011, Eq. 2.26)."""
    roll, pitch = angle[..., 0], angle[..., 1]
    p, q, r = velocity[..., 3], velocity[..., 4], velocity[..., 5]
    swept = q * np.sin(roll) + r * np.cos(roll)
    rates = np.stack([p + swept * np.tan(pitch), q * np.cos(roll) - r * np.sin(roll)], axis=-1)
    return np.asarray(angle + step * rates)
