"""Gauss–Newton on whitened errors of prediction under Student's t: one fit for windows and for innovations.

The errors of a window are nearly one number, its root mean square, and count as one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln

from incsvr.numerics import Array
from incsvr.tracing.errors import Colour, Problem
from incsvr.tracing.hypothesis import Hypothesis
from incsvr.tracing.response import Response
from incsvr.tracing.thresholds import STUDENT_DEGREES

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
    size = hypothesis.vector.size
    low, high = hypothesis.bounds(problem.cells.signals)
    prior = precision(problem, hypothesis, colour)
    errors, response = problem.errors(hypothesis, windows)
    errors = problem.looked_at(errors)
    white, damping, offset_fixed = colour.whiten(errors), FIRST_STEP_DAMPING, False
    for _ in range(rounds):
        theta, squares = hypothesis.vector, mean_squares(white)
        sigma = scale_of(squares[used])
        root = np.sqrt(used * student_weight(squares, sigma))
        rows = _jacobian(problem, hypothesis, colour, errors, response)
        flat, wide = (rows * root).reshape(rows.shape[0], -1), prior * (sigma**2 * white.shape[0])
        information = flat @ flat.T + wide
        pull = flat @ (white * root).ravel() + wide[:, :size] @ theta
        if offset_fixed:
            _fix(hypothesis.basis.size, information, pull)
        before = _objective(squares[used], sigma, float(theta @ prior[:size, :size] @ theta))
        for _ in range(STEP_ATTEMPTS):
            diagonal = np.diag(information)
            step = -np.linalg.solve(information + np.diag(damping * diagonal + 1e-12 * diagonal.max()), pull)
            moved = np.clip(theta + step[:size], low, high)
            tried = hypothesis.moved(moved)
            tried_colour = colour.moved(colour.vector + np.clip(step[size:], -MAX_COLOUR_STEP, MAX_COLOUR_STEP))
            tried_errors, tried_response = problem.errors(tried, windows)
            tried_errors = problem.looked_at(tried_errors)
            tried_white = tried_colour.whiten(tried_errors)
            penalty = float(moved @ prior[:size, :size] @ moved)
            after = _objective(mean_squares(tried_white)[used], sigma, penalty)
            if after < before:
                break
            damping = 10.0 * max(damping, 1e-2)
        else:
            if offset_fixed:
                break
            offset_fixed, damping = True, FIRST_STEP_DAMPING
            continue
        damping = max(0.1 * damping, MIN_STEP_DAMPING)
        hypothesis, colour, errors, white, response = tried, tried_colour, tried_errors, tried_white, tried_response
        if before - after < SETTLED_FALL * white.shape[1]:
            if offset_fixed or damping < STUCK_STEP_DAMPING:
                break
            offset_fixed, damping = True, FIRST_STEP_DAMPING
    squares = mean_squares(white)
    sigma = scale_of(squares[used])
    rows = _jacobian(problem, hypothesis, colour, errors, response)
    weight = used * student_weight(squares, sigma)
    return Fit(hypothesis, colour, sigma, white, rows, weight, log_densities(squares, sigma), response)


def _fix(number: int, information: Array, pull: Array) -> None:
    """Takes one of the free numbers out of the equations (p, p) and (p,) of a step, which leaves it as it is."""
    information[number], information[:, number], pull[number] = 0.0, 0.0, 0.0
    information[number, number] = 1.0


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


def _objective(squares: Array, sigma: float, penalty: float) -> float:
    return 0.5 * penalty - float(np.sum(log_densities(squares, sigma)))


def _jacobian(problem: Problem, hypothesis: Hypothesis, colour: Colour, errors: Array, response: Response) -> Array:
    """(p, length, w) slopes of the whitened errors."""
    own = colour.whiten(problem.looked_at(response.jacobian(hypothesis)))
    return np.concatenate([own, *colour.slopes(errors)])
