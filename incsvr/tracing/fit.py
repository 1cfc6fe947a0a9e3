"""Gauss–Newton on whitened errors of prediction under Student's t: one fit for windows and for innovations.

The errors of a window are nearly one number, its root mean square, and count as one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln

from incsvr.model_trace.thresholds import STUDENT_DEGREES
from incsvr.numerics import Array
from incsvr.tracing.dynamics import Windows
from incsvr.tracing.errors import Colour, Problem
from incsvr.tracing.hypothesis import Hypothesis
from incsvr.tracing.response import Response

MAX_ROUNDS = 12
"""Gauss–Newton steps of a fit at most."""
REFIT_ROUNDS = 2
"""Gauss–Newton steps of a fit without a fold, which begins at the whole."""
SETTLED_FALL = 1e-4
"""Fall of the objective a window below which a fit has settled."""
STEP_ATTEMPTS = 6
"""Steps that are tried in a round."""
FIRST_STEP_DAMPING = 1e-3
"""Levenberg and Marquardt's damping of the first step."""
MIN_STEP_DAMPING = 1e-6
"""Levenberg and Marquardt's damping at least."""
STUCK_STEP_DAMPING = 1.0
"""Levenberg and Marquardt's damping from which on a fit that settles is stuck: at the instant of a command the
likelihood of an offset has a kink, where its slope may lead uphill. The rest is then fitted with the offset fixed."""
MAX_COLOUR_STEP = 2.0
"""Change of the colour's unbounded numbers in a step at most."""
COLOUR_PRECISION = 1e-6
"""Precision of the colour's numbers: keeps the equations solvable where there is no colour to find."""


@dataclass(frozen=True, slots=True)
class Fit:
    """A fitted hypothesis.

    Attributes:
        hypothesis: with its values.
        colour: of the errors, with its values.
        sigma: scale of the whitened errors.
        errors: (length, w) whitened.
        jacobian: (p, length, w) of these, with the hypothesis' free numbers, then the colour's.
        weight: (w,) by which Student's t weighs each window.
        score: (w,) log density of each window.
        response: of the windows to further changes.
    """

    hypothesis: Hypothesis
    colour: Colour
    sigma: float
    errors: Array
    jacobian: Array
    weight: Array
    score: Array
    response: Response

    @property
    def variance(self) -> float:
        """The variance that sums of squares over all errors are divided by."""
        return float(self.sigma**2 * self.errors.shape[0])


def fit(
    problem: Problem,
    hypothesis: Hypothesis,
    colour: Colour,
    rounds: int = MAX_ROUNDS,
    use: NDArray[np.bool_] | None = None,
) -> Fit:
    """The free numbers of greatest posterior likelihood, begun where they are.

    Args:
        use: (w,) the windows that are fitted; all if not given.
    """
    windows = problem.windows
    if use is not None and not problem.of_innovations:
        windows, use = windows.take(use), None
    used = np.ones(windows.first.size, dtype=bool) if use is None else use
    bounds = hypothesis.bounds(problem.cells.signals)
    prior = precision(problem, hypothesis, colour)
    place, damping, offset_fixed = _Place.of(problem, windows, hypothesis, colour), FIRST_STEP_DAMPING, False
    for _ in range(rounds):
        equations = _Equations.of(problem, place, prior, used)
        if offset_fixed:
            equations.fix(hypothesis.basis.size)
        place, fall, damping = _descend(problem, windows, equations, damping, bounds)
        if fall < SETTLED_FALL * place.white.shape[1]:
            if offset_fixed or damping < STUCK_STEP_DAMPING:
                break
            offset_fixed, damping = True, FIRST_STEP_DAMPING
    squares = mean_squares(place.white)
    sigma = scale_of(squares[used])
    weight = used * student_weight(squares, sigma)
    score, jacobian = log_densities(squares, sigma), place.jacobian(problem)
    return Fit(place.hypothesis, place.colour, sigma, place.white, jacobian, weight, score, place.response)


@dataclass(frozen=True, slots=True)
class _Place:
    """A hypothesis and a colour with their values, and the errors that they leave, before and after whitening."""

    hypothesis: Hypothesis
    colour: Colour
    errors: Array
    white: Array
    response: Response

    @staticmethod
    def of(problem: Problem, windows: Windows, hypothesis: Hypothesis, colour: Colour) -> _Place:
        errors, response = problem.errors(hypothesis, windows)
        errors = problem.looked_at(errors)
        return _Place(hypothesis, colour, errors, colour.whiten(errors), response)

    def jacobian(self, problem: Problem) -> Array:
        """(p, length, w) slopes of the whitened errors."""
        own = self.colour.whiten(problem.looked_at(self.response.jacobian(self.hypothesis)))
        return np.concatenate([own, *self.colour.slopes(self.errors)])


@dataclass(frozen=True, slots=True)
class _Equations:
    """The equations of a Gauss–Newton step: information (p, p) and pull (p,), under the scale σ of the errors.

    Attributes:
        prior: (k, k) precision of the hypothesis' free numbers.
        used: (w,) the windows that are fitted.
    """

    place: _Place
    information: Array
    pull: Array
    sigma: float
    prior: Array
    used: NDArray[np.bool_]

    @staticmethod
    def of(problem: Problem, place: _Place, prior: Array, used: NDArray[np.bool_]) -> _Equations:
        theta, squares = place.hypothesis.vector, mean_squares(place.white)
        size, sigma = theta.size, scale_of(squares[used])
        root = np.sqrt(used * student_weight(squares, sigma))
        rows = place.jacobian(problem)
        flat, wide = (rows * root).reshape(rows.shape[0], -1), prior * (sigma**2 * place.white.shape[0])
        pull = flat @ (place.white * root).ravel() + wide[:, :size] @ theta
        return _Equations(place, flat @ flat.T + wide, pull, sigma, prior[:size, :size], used)

    def fix(self, number: int) -> None:
        """Takes one of the free numbers out of the equations, which leave it as it is."""
        self.information[number], self.information[:, number], self.pull[number] = 0.0, 0.0, 0.0
        self.information[number, number] = 1.0

    def step(self, damping: float, bounds: tuple[Array, Array]) -> tuple[Array, Colour]:
        """The hypothesis' free numbers (k,) within their bounds, and the colour, after a damped step."""
        theta, colour, diagonal = self.place.hypothesis.vector, self.place.colour, np.diag(self.information)
        damped = self.information + np.diag(damping * diagonal + 1e-12 * diagonal.max())
        step = -np.linalg.solve(damped, self.pull)
        moved = np.clip(theta + step[: theta.size], *bounds)
        return moved, colour.moved(colour.vector + np.clip(step[theta.size :], -MAX_COLOUR_STEP, MAX_COLOUR_STEP))

    def objective(self, theta: Array, white: Array) -> float:
        """Minus the log posterior, but for a constant, of free numbers (k,) that leave these whitened errors."""
        densities = log_densities(mean_squares(white)[self.used], self.sigma)
        return 0.5 * float(theta @ self.prior @ theta) - float(np.sum(densities))


def _descend(
    problem: Problem, windows: Windows, equations: _Equations, damping: float, bounds: tuple[Array, Array]
) -> tuple[_Place, float, float]:
    """The place after the first step that lowers the objective, the fall, and the next step's damping; without such a
    step the same place, zero, and the damping of the last."""
    place = equations.place
    before = equations.objective(place.hypothesis.vector, place.white)
    for _ in range(STEP_ATTEMPTS):
        theta, colour = equations.step(damping, bounds)
        tried = _Place.of(problem, windows, place.hypothesis.moved(theta), colour)
        fall = before - equations.objective(theta, tried.white)
        if fall > 0.0:
            return tried, fall, max(0.1 * damping, MIN_STEP_DAMPING)
        damping = 10.0 * max(damping, 1e-2)
    return place, 0.0, damping


def held_out_scores(problem: Problem, fitted: Fit, folds: NDArray[np.intp]) -> Array:
    """(w,) log density of each window by a fit to all windows but those of its fold, begun at the whole fit.

    Args:
        folds: (w,) number of the fold of each window.
    """
    score = np.empty(folds.size)
    for fold in np.unique(folds):
        out = folds == fold
        left = fit(problem, fitted.hypothesis, fitted.colour, REFIT_ROUNDS, ~out)
        score[out] = score_on(problem, left, out)
    return score


def score_on(problem: Problem, fitted: Fit, which: NDArray[np.bool_]) -> Array:
    """(k,) log density of some windows by a fit to others."""
    every = problem.of_innovations  # innovations follow from those before them
    windows = problem.windows if every else problem.windows.take(which)
    errors, _ = problem.errors(fitted.hypothesis, windows)
    squares = mean_squares(fitted.colour.whiten(problem.looked_at(errors)))
    return log_densities(squares[which] if every else squares, fitted.sigma)


def precision(problem: Problem, hypothesis: Hypothesis, colour: Colour) -> Array:
    """(p, p) precision of the prior of the free numbers, the hypothesis' first."""
    size, count, more = hypothesis.basis.size, hypothesis.vector.size, colour.vector.size
    found = np.zeros((count + more, count + more))
    found[:size, :size] = hypothesis.basis.precision
    found[size, size] = problem.offset_deviation**-2.0
    found[count:, count:] = COLOUR_PRECISION * np.eye(more)
    return found


def mean_squares(errors: Array) -> Array:
    """(w,) mean square of each window's errors."""
    return np.asarray(np.mean(errors**2, axis=0))


def scale_of(squares: Array) -> float:
    """σ under Student's t of windows with these mean squares (w,)."""
    variance = max(float(np.median(squares)), 1e-300)
    for _ in range(50):
        new = max(float(np.mean(student_weight(squares, np.sqrt(variance)) * squares)), 1e-300)
        if abs(new - variance) < 1e-6 * variance:
            break
        variance = new
    return float(np.sqrt(variance))


def student_weight(squares: Array, sigma: float) -> Array:
    """(w,) by which Student's t weighs windows."""
    return np.asarray((STUDENT_DEGREES + 1.0) / (STUDENT_DEGREES + squares / sigma**2))


def log_densities(squares: Array, sigma: float) -> Array:
    """(w,) log density of windows under Student's t of scale σ."""
    constant = (
        gammaln(0.5 * (STUDENT_DEGREES + 1.0)) - gammaln(0.5 * STUDENT_DEGREES) - 0.5 * np.log(np.pi * STUDENT_DEGREES)
    )
    return np.asarray(
        constant - np.log(sigma) - 0.5 * (STUDENT_DEGREES + 1.0) * np.log1p(squares / (sigma**2 * STUDENT_DEGREES))
    )
