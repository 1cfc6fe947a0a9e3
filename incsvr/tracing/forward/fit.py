"""Maximum likelihood of one hypothesis: coefficients by generalised least squares, the noise by its own likelihood.

The innovations follow Student's t, found by iteratively reweighted least squares; the noise's ratios by damped
Gauss–Newton steps, the coefficients found beside each.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from incsvr.tracing.forward.damping import DampingBasis
from incsvr.tracing.forward.equations import Linear, Part, assumed_inertia, columns, predicted
from incsvr.tracing.forward.grid import Grid
from incsvr.tracing.forward.noise import Noise
from incsvr.tracing.forward.regression import assemble, log_likelihood, prior, solve, student_weight

Array = NDArray[np.float64]

PASSES = 2
"""In which noise and coefficients follow each other; more change nothing."""

ROUNDS, CONSISTENT = 10, 1e-3
"""In which the predicted rate follows the fitted curve, and the relative change of the curve below which it does."""

NUDGE, DAMPING, LEAST, ATTEMPTS, ENOUGH = 0.01, 0.01, 1e-4, 8, 0.02
"""Of the noise's search (Levenberg–Marquardt): of the numerical slope, the damping at first, the least curvature per
cell
in variances, how often a step is damped more, and the log-likelihood below which a step ends it."""


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
        if not self.surprises:
            return 0.0
        count = self.surprises
        weighted = self.white * np.sqrt(self.weight)
        beside = np.linalg.qr(weighted[:-count].T)[0]
        seen = weighted[-count:] - (weighted[-count:] @ beside) @ beside.T
        return float(np.sum((self.theta[-count:] @ seen) ** 2)) / self.sigma**2

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
