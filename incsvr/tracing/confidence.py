"""Intervals of what effects say, such as their parameters: the sandwich estimator over blocks, by the delta method."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
from numpy.typing import NDArray

from incsvr.effects import Effect, Term
from incsvr.model_trace.statistics import NORMAL_95
from incsvr.numerics import Array
from incsvr.tracing.errors import Problem
from incsvr.tracing.fit import Fit, precision
from incsvr.tracing.folds import slopes
from incsvr.tracing.hypothesis import Part

SLOPE_DEVIATIONS = 0.1
"""Deviations of a free number over which the slope of a parameter is taken."""


Values = Callable[[Effect, Term], Mapping[str, float]]
"""What a term of an effect says, by name."""


def intervals(
    problem: Problem, fitted: Fit, blocks: NDArray[np.intp], values: Values
) -> list[dict[str, tuple[float, float]]]:
    """95 % interval of every value of every part of the fit."""
    covariance = covariance_of(problem, fitted, blocks)
    places = fitted.hypothesis.positions()
    return [
        _of_part(part, covariance[place, place], partial(values, part.effect))
        for part, place in zip(fitted.hypothesis.parts, places, strict=True)
    ]


def covariance_of(problem: Problem, fitted: Fit, blocks: NDArray[np.intp]) -> Array:
    """(p, p) of the free numbers, however errors within a block correlate (H. White, Econometrica 50, 1982).

    Where there are hardly more blocks than numbers, the plain information is the safer one of the two.
    """
    information, sums = slopes(fitted, blocks)
    information = information + precision(problem, fitted.hypothesis, fitted.colour)
    inverse = np.linalg.pinv(information, hermitian=True)
    count = sums.shape[1]
    sandwich = inverse @ (sums @ sums.T) @ inverse * (count / max(count - information.shape[0], 1))
    return np.asarray(sandwich if count > 2 * information.shape[0] else inverse)


def _of_part(
    part: Part, covariance: Array, values: Callable[[Term], Mapping[str, float]]
) -> dict[str, tuple[float, float]]:
    """Intervals of the values, whose slopes are taken numerically."""
    vector = part.vector
    deviations = np.sqrt(np.maximum(np.diag(covariance), 0.0))

    def moved(k: int, by: float) -> Mapping[str, float]:
        changed = vector.copy()
        changed[k] += by
        return values(part.moved(changed).term)

    found = {}
    for name, value in values(part.term).items():
        slope = np.zeros(vector.size)
        for k, deviation in enumerate(deviations):
            step = SLOPE_DEVIATIONS * float(deviation) or 1e-9
            slope[k] = (moved(k, step)[name] - moved(k, -step)[name]) / (2.0 * step)
        half = NORMAL_95 * float(np.sqrt(max(float(slope @ covariance @ slope), 0.0)))
        found[name] = (value - half, value + half)
    return found
