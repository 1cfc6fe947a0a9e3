"""What each candidate would change of a predictor's errors, to first order, and the normal equations of all of them.

A predictor is corrected by each sample, so it stays near the data and its errors are nearly linear in what it lacks.
All candidates therefore are weighed by linear algebra on one set of slopes; only the best are fitted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from incsvr.model.candidates import Candidate
from incsvr.model.fitting import Fit, unit, weights
from incsvr.model.left_out import Gain, blocks, folds, gain
from incsvr.model.simulation import predict, simulate
from incsvr.model.tangent import tangent
from incsvr.numerics import Array


@dataclass(frozen=True, slots=True)
class Evidence:
    """The evidence for an effect.

    Attributes:
        gain: of the logarithm of the likelihood on all windows.
        excluded: the gain on windows that its fit excluded.
        sure: deviations by which its coefficients are away from nothing, the larger of two estimates of the deviation.
        step: coefficients, in units of the directions.
    """

    gain: float
    excluded: Gain
    sure: float
    step: tuple[float, ...]


@dataclass(frozen=True)
class Directions:
    """The normal equations of a fit with all candidates, each window's share.

    Attributes:
        found: the fit.
        place: of each candidate's columns; those of θ come first.
        normal, gradient: (windows, p + columns, p + columns) and (windows, p + columns).
    """

    found: Fit
    place: Mapping[int, tuple[int, ...]]
    normal: Array
    gradient: Array

    def evidence(self, which: int) -> Evidence:
        """The evidence for a candidate, by its place among them."""
        windows, p = self.found.problem.windows, len(self.found.names)
        at = np.r_[np.arange(p), self.place[which]].astype(np.intp)
        normal, gradient = self.normal[:, at[:, None], at], self.gradient[:, at]
        size = np.sqrt(np.einsum("wii->i", normal)) + 1e-30
        normal, gradient = normal / np.outer(size, size), gradient / size
        prior = np.diag(np.r_[self.found.prior / size[:p] ** 2, np.zeros(at.size - p)] + 1e-6)
        whole, slope = normal.sum(axis=0) + prior, gradient.sum(axis=0)
        with_it, rest = np.linalg.solve(whole, slope), np.linalg.solve(whole[:p, :p], slope[:p])
        fold, by_window = folds(windows), np.zeros(windows.first.size)
        for k in np.unique(fold):
            own = fold == k
            other, left = whole - normal[own].sum(axis=0), slope - gradient[own].sum(axis=0)
            new, old = np.linalg.solve(other, left), np.linalg.solve(other[:p, :p], left[:p])
            by_window[own] = _gained(normal[own], gradient[own], new)
            by_window[own] -= _gained(normal[own][:, :p, :p], gradient[own][:, :p], old)
        total = 0.5 * float(slope @ with_it - slope[:p] @ rest)
        sure = self._sureness(whole, normal, gradient, with_it)
        step = tuple((with_it / size)[p:].tolist())
        return Evidence(total, gain(by_window, windows), sure, step)

    def _sureness(self, whole: Array, normal: Array, gradient: Array, solution: Array) -> float:
        """Deviations of the candidate's coefficients, by independent errors or by the scatter of blocks."""
        p = len(self.found.names)
        inverse = np.linalg.inv(whole)
        rest = gradient - normal @ solution
        block = blocks(self.found.problem.windows)
        by_block = np.stack([np.bincount(block, each) for each in rest.T], axis=1)
        spread = inverse @ (by_block.T @ by_block) @ inverse
        new = solution[p:]
        squares = [float(new @ np.linalg.lstsq(each[p:, p:], new, rcond=1e-12)[0]) for each in (spread, inverse)]
        return float(np.sqrt(max(min(squares) - (new.size - 1), 0.0)))


def directions(found: Fit, every: Sequence[Candidate]) -> Directions:
    """The directions of candidates: derivatives of rows, finite changes of all else."""
    structure, problem = found.structure, found.problem
    windows = problem.windows
    rows = {row.key: row for each in every for row in each.rows}
    wide = structure.plus(rows=list(rows.values()))
    theta = {**dict.fromkeys(rows, 0.0), **found.theta}
    names = (*found.names, *rows)
    units = np.array([unit(name, wide, theta, windows) for name in names])
    point = np.array([theta[name] for name in wide.names])
    order = [wide.names.index(name) for name in names]
    course = simulate(wide, point, windows, found.starts)
    of_wide = np.array([units[names.index(name)] for name in wide.names])
    slopes = problem.white(tangent(course, point, of_wide))
    by, by_start = slopes[:, order], slopes[:, len(names) :]
    error = problem.white(windows.measured - course.predicted)
    finite, place = list[Array](), dict[int, tuple[int, ...]]()
    for k, each in enumerate(every):
        if each.rows:
            place[k] = tuple(names.index(row.key) for row in each.rows)
        else:
            place[k] = (len(names) + len(finite),)
            finite.append(error - _errors_with(found, each))
    whole = np.column_stack([by, *finite, by_start])
    return Directions(found, place, *_normal_equations(found, error, whole, len(names) + len(finite)))


def _errors_with(found: Fit, candidate: Candidate) -> Array:
    """(samples,) the errors with a candidate as it begins; a memory has a hundredth of the usual effort."""
    structure, problem = candidate.structure, found.problem
    theta = {**found.theta, **candidate.start}
    for row in structure.rows:
        if row.follows and row.key in candidate.start:
            theta[row.key] = 0.01 * unit(row.key, structure, theta, problem.windows)
    column = np.array([theta[name] for name in structure.names])[:, None]
    return problem.errors(predict(structure, column, problem.windows, found.starts[:, None]))[:, 0]


def _normal_equations(found: Fit, error: Array, by: Array, count: int) -> tuple[Array, Array]:
    """Each window's normal equations of `count` columns, the starts that follow them eliminated."""
    windows = found.problem.windows
    weight = weights(error, found.scale, windows)
    sensor = np.minimum(windows.noise, found.scale)
    normal, gradient = np.empty((windows.first.size, count, count)), np.empty((windows.first.size, count))
    for w, part in enumerate(windows.samples):
        weighted = by[part].T * weight[part]
        block, slope = weighted @ by[part], weighted @ error[part]
        slope[count:] -= (found.starts[:, w] - windows.starts[:, w]) / sensor**2
        across = block[:count, count:]
        solved = np.linalg.solve(
            block[count:, count:] + np.diag(sensor**-2.0), np.column_stack([across.T, slope[count:]])
        )
        normal[w] = block[:count, :count] - across @ solved[:, :-1]
        gradient[w] = slope[:count] - across @ solved[:, -1]
    return normal, gradient


def _gained(normal: Array, gradient: Array, step: Array) -> Array:
    """(windows,) by how much a step lowers each window's cost."""
    return np.asarray(gradient @ step - 0.5 * np.einsum("i,wij,j->w", step, normal, step))
