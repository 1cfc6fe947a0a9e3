"""Fits a vehicle's parameters to predictions: windows of the recordings, each simulated from its measured velocities.

The sum of squared prediction errors is minimised by Gauss–Newton steps under Student's t, with the slopes of all
parameters by the tangent of the simulation. It is the criterion by which the model is used.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from incsvr.numerics import Array
from incsvr.vehicle.motion import WholeMotion
from incsvr.vehicle.sensitivities import sensitivities
from incsvr.vehicle.simulation import simulate
from incsvr.vehicle.structure import Structure

DEGREES_OF_FREEDOM = 6.0
"""Degrees of freedom of Student's t, the law of the windows' errors; the tracer's are as many."""
MAX_STEPS = 12
"""Gauss–Newton steps at most."""
MIN_FALL = 1e-4
"""Relative fall of the criterion below which the fit ends."""
RELATIVE_DIFFERENCE = 1e-4
"""Step of the differences that give the slopes along lags, in a lag's scale."""
MAX_SLOPE = 1000.0
"""Largest change of a velocity, in the fastest one, by a parameter's own order: those of a usual window reach 10."""
WRONG_END = 2.0
"""Ratio of errors from which a search ended in a wrong minimum: ends that data hardly tell apart differ by a fifth."""
PRIOR_SCALES = 30.0
"""Deviation of a parameter's prior about its start, in its scale: it only holds what is not excited."""


@dataclass(frozen=True, slots=True)
class Windows:
    """The stretches of a motion that are predicted.

    Attributes:
        motion: the recorded motion.
        first: (windows,) first cells.
        cells: length of each.
    """

    motion: WholeMotion
    first: NDArray[np.intp]
    cells: int

    def errors(self, structure: Structure, parameters: Array) -> Array:
        """Simulated less measured velocities of the simulated axes, (models, windows, cells, axes)."""
        course = simulate(structure, parameters, self.motion, self.first, self.cells)
        measured = np.stack([self.motion.velocity[self.first + k] for k in range(1, self.cells + 1)])
        error = (course[1:] - measured[:, None])[..., structure.rows]
        return np.ascontiguousarray(error.transpose(1, 2, 0, 3))


@dataclass(frozen=True, slots=True)
class Fit:
    """A fitted model.

    Attributes:
        structure: what the parameters mean.
        parameters: (size,).
        scale: (size,) the order of each parameter.
        variance: (axes,) of the errors of prediction.
        error: (windows, cells, axes) of prediction.
        slope: (size, windows, cells, axes) of the errors along each parameter.
        weight: (windows, axes) of each window's errors, Student's weight over the variance.
    """

    structure: Structure
    parameters: Array
    scale: Array
    variance: Array
    error: Array
    slope: Array
    weight: Array


def losses(error: Array, variance: Array) -> Array:
    """(windows,) (ν + 1) Σ_axes log(1 + q/ν), with q the mean square of a window's errors over the axis's variance."""
    share = np.mean(error**2, axis=-2) / variance
    return np.asarray(np.sum((DEGREES_OF_FREEDOM + 1.0) * np.log1p(share / DEGREES_OF_FREEDOM), axis=-1))


def fit(
    windows: Windows,
    structure: Structure,
    start: Array,
    scale: Array,
    bounds: tuple[Array, Array],
    max_steps: int = MAX_STEPS,
) -> Fit:
    """The parameters that predict the windows best.

    Args:
        start, scale: (size,) where the search begins, and the order of each parameter.
        bounds: lower and upper (size,) each.
        max_steps: Gauss–Newton steps at most.
    """
    parameters, damping = np.clip(start, *bounds), 1e-3
    error = windows.errors(structure, parameters[None])[0]
    variance = robust_variance(error)
    loss = float(losses(error, variance).sum())
    for _ in range(max_steps):
        slope = slopes(windows, structure, parameters, scale)
        weight = student_weight(error, variance)
        normal, gradient = normal_equations(slope, error, weight)
        moved = None
        for _ in range(8):
            step = _bounded_step(normal, gradient, damping, scale, parameters, start, bounds)
            if is_a_body(structure, parameters + step):
                tried = windows.errors(structure, (parameters + step)[None])[0]
                fallen = float(losses(tried, variance).sum())
                if fallen < loss:
                    moved = (parameters + step, tried, fallen)
                    break
            damping *= 6.0
        if moved is None:
            break
        fall = (loss - moved[2]) / abs(loss)
        parameters, error, _ = moved
        variance = robust_variance(error)
        loss = float(losses(error, variance).sum())
        damping = max(damping / 6.0, 1e-7)
        if fall < MIN_FALL:
            break
    slope = slopes(windows, structure, parameters, scale)
    return Fit(structure, parameters, scale, variance, error, slope, student_weight(error, variance))


def fit_from_afar(
    windows: Windows, structure: Structure, start: Array, scale: Array, bounds: tuple[Array, Array]
) -> Fit:
    """`fit` from a guess of orders of magnitude.

    The search also begins at what predicts the windows' first thirds best: what happens soon is nearly linear in the
    parameters, so that a guess that is ten times wrong does no harm there. Its end is taken where the other one's
    errors are WRONG_END times as large, in the geometric mean over the axes; a small difference is one of noise.
    """
    direct = fit(windows, structure, start, scale, bounds)
    short = Windows(windows.motion, windows.first, max(1, windows.cells // 3))
    near = fit(short, structure, start, scale, bounds)
    found = fit(windows, structure, near.parameters, scale, bounds)
    ratio = float(np.exp(0.5 * np.mean(np.log(direct.variance / found.variance))))
    return found if ratio > WRONG_END else direct


def slopes(windows: Windows, structure: Structure, parameters: Array, scale: Array) -> Array:
    """∂error/∂parameter, (size, windows, cells, axes); zero in windows whose simulation runs away.

    Near a pitch of 90° the slopes of a window grow without bound, and would outweigh those of all others.
    """
    lag_shift = RELATIVE_DIFFERENCE * scale[scale.size - len(structure.lags) :]
    with np.errstate(over="ignore", invalid="ignore"):
        found = sensitivities(structure, parameters, lag_shift, windows.motion, windows.first, windows.cells)
        fastest = np.abs(windows.motion.velocity[:, structure.rows]).max(axis=0) + 1e-12
        reach = np.abs(found * scale[:, None, None, None] / fastest).max(axis=(0, 2, 3))
    found[:, ~(reach < MAX_SLOPE)] = 0.0
    return found


def robust_variance(error: Array) -> Array:
    """(axes,) the variance of most windows' errors: the median of their mean squares over that of normal ones."""
    return np.asarray(np.median(np.mean(error**2, axis=1), axis=0) / 0.7 + 1e-18)


def student_weight(error: Array, variance: Array) -> Array:
    """(windows, axes) weights of Student's t over the variance."""
    share = np.mean(error**2, axis=1) / variance
    return np.asarray((DEGREES_OF_FREEDOM + 1.0) / (DEGREES_OF_FREEDOM + share) / variance)


def normal_equations(slope: Array, error: Array, weight: Array) -> tuple[Array, Array]:
    """JᵀWJ (size, size) and JᵀWe (size,), a window's cells counting as one number."""
    rows = slope.reshape(slope.shape[0], -1)
    weights = np.broadcast_to(weight[:, None, :] / error.shape[1], error.shape).ravel()
    return (rows * weights) @ rows.T, (rows * weights) @ error.ravel()


def is_a_body(structure: Structure, parameters: Array) -> bool:
    """Whether the simulated part of M is positive definite."""
    rows = structure.rows
    mass = structure.mass_matrix(parameters[None])[0][np.ix_(rows, rows)]
    return bool(np.linalg.eigvalsh(mass)[0] > 0.0)


def _bounded_step(
    normal: Array,
    gradient: Array,
    damping: float,
    scale: Array,
    parameters: Array,
    start: Array,
    bounds: tuple[Array, Array],
) -> Array:
    """The Levenberg–Marquardt step within the bounds."""
    prior = np.diag(1.0 / (PRIOR_SCALES * scale) ** 2)
    matrix = normal + damping * np.diag(np.diag(normal)) + prior
    pull = gradient + prior @ (parameters - start)
    root = np.linalg.cholesky(matrix / np.outer(1 / scale, 1 / scale))
    right = np.linalg.solve(root, -pull * scale)
    low, high = ((bound - parameters) / scale for bound in bounds)
    solved = lsq_linear(root.T, right, bounds=(low - 1e-12, high + 1e-12))
    return np.asarray(solved.x * scale)
