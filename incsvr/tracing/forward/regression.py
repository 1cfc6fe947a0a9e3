"""The equations of a hypothesis as a regression, and the law of its innovations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln

from incsvr.tracing.forward.damping import DampingBasis
from incsvr.tracing.forward.equations import Linear, columns, predicted, target, thrust
from incsvr.tracing.forward.grid import Grid
from incsvr.tracing.forward.noise import Noise
from incsvr.tracing.forward.thresholds import DEGREES, SHIFT

Array = NDArray[np.float64]

RIDGE = 1e-8
"""Of the information's trace: a spline's value where the vehicle never was is not known."""

MOST_PIECES = 40
"""Up to which every piece has a free beginning: beyond, the pieces' noise is taken for settled."""


@dataclass(frozen=True, slots=True)
class Regression:
    """The equations of a hypothesis.

    Attributes:
        target: (n,) what damping and effects must make up for [N m].
        rows: (p, n) regressors.
        positions: for each part, where its coefficients stand.
        starts: (pieces + 1,) first cell of each piece, and the end.
        surprise: (m, n) regressors of the innovations themselves, the last of all.
    """

    target: Array
    rows: Array
    positions: tuple[slice, ...]
    starts: NDArray[np.intp]
    surprise: Array

    def whitened(self, noise: Noise) -> tuple[Array, Array]:
        """(p + m, n) regressors and (n,) target of the innovations."""
        white = self.whiten(noise, np.concatenate([self.rows, self.target[None, :]]))
        return np.concatenate([white[:-1], self.surprise]), white[-1]

    def whiten(self, noise: Noise, values: Array) -> Array:
        """(…, n) innovations of (…, n) values."""
        return noise.whiten(values, self.starts)


def assemble(grid: Grid, model: Linear) -> Regression:
    """The equations with the rate as this model predicts it."""
    prediction = predicted(grid, model)
    s = prediction.signals
    damping = np.mean([model.basis.columns(rate) for rate in prediction.path], axis=0)
    rows = [damping, grid.shift[None, :]]
    pieces = grid.starts.size - 1
    if pieces <= MOST_PIECES:
        beginnings = np.zeros((pieces, len(s)))
        beginnings[np.arange(pieces), grid.starts[:-1]] = 1.0
        rows.append(beginnings)
    at, positions = sum(row.shape[0] for row in rows), list[slice]()
    for part in model.parts:
        if part.thrust:
            positions.append(slice(at, at))
            continue
        rows.append(columns(part, s))
        positions.append(slice(at, at + rows[-1].shape[0]))
        at = positions[-1].stop
    moment = target(grid, thrust(grid.signals, model.parts))
    return Regression(moment, np.concatenate(rows), tuple(positions), grid.starts, grid.surprise)


def prior(grid: Grid, basis: DampingBasis, size: int) -> Array:
    """(p,) precision of the regressors' prior: that of the shift, at its place behind the damping."""
    precision = np.zeros(size)
    precision[basis.size] = (SHIFT * grid.torque_period) ** -2
    return precision


def solve(white: Array, y: Array, weight: Array, variance: float, precision: Array) -> Array:
    """(p,) generalised least squares with a prior on some coefficients."""
    root = np.sqrt(weight)
    scaled = white * root
    information = scaled @ scaled.T + variance * np.diag(precision)  # of one matrix and itself: half the products
    information[np.diag_indices_from(information)] += RIDGE * np.diag(information) + 1e-300
    return np.asarray(np.linalg.solve(information, scaled @ (root * y)))


def student_weight(innovation: Array, sigma: float) -> Array:
    """(n,) by which Student's t weighs each innovation."""
    return np.asarray((DEGREES + 1.0) / (DEGREES + (innovation / sigma) ** 2))


def log_likelihood(innovation: Array, sigma: float) -> float:
    """Of (n,) innovations under Student's t of this scale."""
    return float(np.sum(log_densities(innovation, sigma)))


def log_densities(innovation: Array, sigma: float) -> Array:
    """(n,) of each innovation under Student's t of this scale."""
    constant = gammaln(0.5 * (DEGREES + 1.0)) - gammaln(0.5 * DEGREES) - 0.5 * np.log(np.pi * DEGREES)
    spread = np.log1p((innovation / sigma) ** 2 / DEGREES)
    return np.asarray(constant - np.log(sigma) - 0.5 * (DEGREES + 1.0) * spread)
