"""Maximum likelihood of one hypothesis: coefficients by generalised least squares, the noise by its own likelihood.

The innovations follow Student's t, found by iteratively reweighted least squares; the noise's ratios by damped
Gauss–Newton steps, the coefficients found beside each.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln

from incsvr.tracing.damping import DampingBasis
from incsvr.tracing.equations import Linear, Part, assumed_inertia, columns, predicted, target, thrust
from incsvr.tracing.grid import Grid
from incsvr.tracing.noise import Noise
from incsvr.tracing.thresholds import DEGREES, SHIFT

Array = NDArray[np.float64]

PASSES = 2
"""In which noise and coefficients follow each other; more change nothing."""

ROUNDS, CONSISTENT = 10, 1e-3
"""In which the predicted rate follows the fitted curve, and the relative change of the curve below which it does."""

NUDGE, DAMPING, LEAST, ATTEMPTS, ENOUGH = 0.01, 0.01, 1e-4, 8, 0.02
"""Of the noise's search (Levenberg–Marquardt): of the numerical slope, the damping at first, the least curvature per
cell
in variances, how often a step is damped more, and the log-likelihood below which a step ends it."""

RIDGE = 1e-8
"""Of the information's trace: a spline's value where the vehicle never was is not known."""

MOST_PIECES = 40
"""Up to which every piece has a free beginning: beyond, the pieces' noise is taken for settled."""


@dataclass(frozen=True, slots=True)
class Fit:
    """A fitted hypothesis.

    Attributes:
        model: damping and effects with their values.
        noise: its colour.
        sigma: scale of the innovations [N m].
        log_likelihood: of the innovations, with the prior of the shift.
        innovation: (n,) [N m].
        weight: (n,) of each, by Student's t.
        white: (p, n) whitened regressors: damping, shift, beginnings, effects.
        theta: (p,) their coefficients.
        positions: for each part, where its coefficients stand in theta; empty for thrust effects.
        shift: by how much the torque's stamps are late [s].
        surprises: how many of the last regressors are the commands' surprise.
    """

    model: Linear
    noise: Noise
    sigma: float
    log_likelihood: float
    innovation: Array
    weight: Array
    white: Array
    theta: Array
    positions: tuple[slice, ...]
    shift: float
    surprises: int

    @property
    def parts(self) -> tuple[Part, ...]:
        return self.model.parts

    @property
    def misfit(self) -> float:
        """2 Δℓ of what the commands' surprise still explains: next to nothing where the controller saw the log's
        gyro."""
        told = self.surprises
        weighted = self.white * np.sqrt(self.weight)
        beside = np.linalg.qr(weighted[:-told].T)[0]
        seen = weighted[-told:] - (weighted[-told:] @ beside) @ beside.T
        return float(np.sum((self.theta[-told:] @ seen) ** 2)) / self.sigma**2

    def names(self) -> tuple[str, ...]:
        return tuple(part.name for part in self.parts)


def fit(
    grid: Grid, parts: Sequence[Part] = (), start: Fit | None = None, *, search: int = 15, passes: int = PASSES
) -> Fit:
    """The hypothesis with these effects, the searched parameters as they are.

    Args:
        start: a fit of a similar hypothesis, to these recordings or others, from which noise and damping begin.
        search: Gauss–Newton steps of the noise at most; 0 keeps the noise of `start`.
        passes: in which noise and coefficients follow each other.
    """
    n = len(grid.signals)
    if start is None:
        basis = DampingBasis.over(grid.signals.rate)
        noise, weight = Noise.start(grid.cell, grid.signals.scale), np.ones(n)
        model = Linear(basis, np.zeros(basis.size), tuple(parts), np.zeros(n))
        start = _pass(grid, model, noise, weight)
    weight = start.weight if start.weight.size == n else np.ones(n)
    model = replace(start.model, parts=tuple(parts), loss=np.zeros(n))
    fitted = _consistent(grid, _pass(grid, model, start.noise, weight))
    for _ in range(passes):
        noise = _noise(grid, fitted, search) if search else fitted.noise
        fitted = _consistent(grid, _pass(grid, fitted.model, noise, fitted.weight))
    return fitted


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
    weighted = white * weight
    information = weighted @ white.T + variance * np.diag(precision)
    information[np.diag_indices_from(information)] += RIDGE * np.diag(information) + 1e-300
    return np.asarray(np.linalg.solve(information, weighted @ y))


def student_weight(innovation: Array, sigma: float) -> Array:
    """(n,) by which Student's t weighs each innovation."""
    return np.asarray((DEGREES + 1.0) / (DEGREES + (innovation / sigma) ** 2))


def log_likelihood(innovation: Array, sigma: float) -> float:
    """Of (n,) innovations under Student's t of this scale."""
    constant = gammaln(0.5 * (DEGREES + 1.0)) - gammaln(0.5 * DEGREES) - 0.5 * np.log(np.pi * DEGREES)
    spread = np.log1p((innovation / sigma) ** 2 / DEGREES)
    return float(innovation.size * (constant - np.log(sigma)) - 0.5 * (DEGREES + 1.0) * np.sum(spread))


def _consistent(grid: Grid, fitted: Fit) -> Fit:
    """The fit whose rate is predicted by its own curve: a vehicle that settles within a few cells needs some rounds."""
    low, high = (float(q) for q in np.quantile(grid.signals.rate, [0.002, 0.998]))
    rates = np.linspace(low, high, 41)
    for _ in range(ROUNDS):
        before = fitted.model.damping_at(rates)
        model = replace(fitted.model, loss=_loss(grid, fitted, fitted.parts))
        fitted = _pass(grid, model, fitted.noise, fitted.weight)
        after = fitted.model.damping_at(rates)
        if np.max(np.abs(after - before)) < CONSISTENT * np.max(np.abs(after)):
            break
    return fitted


def _pass(grid: Grid, model: Linear, noise: Noise, weight: Array) -> Fit:
    """Coefficients, scale and weights with this noise and this prediction of the rate."""
    regression = assemble(grid, model)
    white, white_y = regression.whitened(noise)
    precision = prior(grid, model.basis, white.shape[0])
    sigma = float(np.sqrt(np.mean(weight * white_y**2))) or 1e-12
    for _ in range(3):
        theta = solve(white, white_y, weight, sigma**2, precision)
        innovation = white_y - theta @ white
        for _ in range(3):
            sigma = max(float(np.sqrt(np.mean(student_weight(innovation, sigma) * innovation**2))), 1e-12)
        weight = student_weight(innovation, sigma)
    knots = model.basis.size
    parts = tuple(
        part if part.thrust else _valued(part, theta[where], grid.signals.inertia, model.parts)
        for part, where in zip(model.parts, regression.positions, strict=True)
    )
    likelihood = log_likelihood(innovation, sigma) - 0.5 * float(precision @ theta**2)
    model = replace(model, damping=theta[:knots], parts=parts)
    return Fit(
        model,
        noise,
        sigma,
        likelihood,
        innovation,
        weight,
        white,
        theta,
        regression.positions,
        shift=float(theta[knots]),
        surprises=regression.surprise.shape[0],
    )


def _valued(part: Part, theta: Array, declared: float, parts: Sequence[Part]) -> Part:
    """The part with its fitted coefficients.

    The inertia's regressor is the acceleration that an assumed inertia I predicts: with the true one I₀ + ΔI its
    coefficient is θ = ΔI I/(I₀ + ΔI), from which ΔI follows without going round in circles.
    """
    values = theta.tolist()
    if part.effect.acts == "inertia":
        assumed = assumed_inertia(declared, parts)
        values = [values[0] * declared / max(assumed - values[0], 0.05 * assumed)]
    return Part(part.effect, replace(part.term, coefficients=tuple(values)))


def _loss(grid: Grid, fitted: Fit, parts: Sequence[Part]) -> Array:
    """(n,) Σ θ φ [N m] of the parts whose coefficients are known, but for the inertia."""
    wanted = [p for p in parts if not p.thrust and p.effect.acts != "inertia" and p.term.coefficients]
    if not wanted:
        return np.zeros(len(grid.signals))
    s = predicted(grid, fitted.model).signals
    return np.asarray(np.sum([np.array(p.term.coefficients) @ columns(p, s) for p in wanted], axis=0))


def _noise(grid: Grid, fitted: Fit, steps: int) -> Noise:
    """The noise of greatest likelihood, the coefficients found beside each (variable projection), by damped
    Gauss–Newton
    steps on the innovations; the weights as they are.
    """
    regression = assemble(grid, fitted.model)
    y, rows = regression.target, regression.rows
    precision, root, noise = (
        prior(grid, fitted.model.basis, rows.shape[0] + regression.surprise.shape[0]),
        np.sqrt(fitted.weight),
        fitted.noise,
    )

    def projected(each: Noise) -> tuple[Array, Array, Array, float]:
        white, white_y = regression.whitened(each)
        theta = solve(white, white_y, fitted.weight, fitted.sigma**2, precision)
        innovation = white_y - theta @ white
        return white, theta, innovation, float(fitted.weight @ innovation**2)

    white, theta, innovation, square = projected(noise)
    damping = DAMPING
    for _ in range(steps):
        vector, left = noise.to_vector(), y - theta[: rows.shape[0]] @ rows
        beside = theta[rows.shape[0] :] @ regression.surprise
        moved = [Noise.from_vector(vector + NUDGE * unit) for unit in np.eye(vector.size)]
        nudged = [regression.whiten(each, left) - beside for each in moved]
        slopes = (np.stack(nudged) - innovation) / NUDGE
        frame = np.linalg.qr((white * root).T)[0]
        seen = slopes * root
        seen = seen - (seen @ frame) @ frame.T
        information, pull = seen @ seen.T, seen @ (root * innovation)
        for _ in range(ATTEMPTS):
            damped = information + damping * np.diag(np.diag(information) + LEAST * y.size * fitted.sigma**2)
            step = -np.linalg.solve(damped, pull)
            tried = projected(Noise.from_vector(vector + step))
            if tried[-1] < square:
                break
            damping *= 10.0
        else:
            break
        damping = max(0.1 * damping, 1e-6)
        noise, before = Noise.from_vector(vector + step), square
        white, theta, innovation, square = tried
        if 0.5 * y.size * np.log(before / square) < ENOUGH:
            break
    return noise
