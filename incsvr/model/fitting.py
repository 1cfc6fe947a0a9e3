"""The one fit: Gauss–Newton under Student's t over all windows, whose starts are fitted with the parameters.

A window's start is a measurement with the sensor's noise, never smoothed. It is eliminated window by window, so that
each window's share of the normal equations can be subtracted when the window is excluded.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from incsvr.model.efforts import Stage
from incsvr.model.factors import one_by_one
from incsvr.model.series import effort_of
from incsvr.model.simulation import Course, simulate
from incsvr.model.structure import Structure, Theta, is_logarithm
from incsvr.model.tangent import tangent
from incsvr.model.windows import Windows
from incsvr.numerics import Array, robust_deviation, root_mean_square

DEGREES = 6.0
"""Degrees of freedom of Student's t: outliers of a gyro or a log weigh little; normal errors lose 5 % of weight."""


@dataclass(frozen=True)
class Problem:
    """What a structure is fitted to.

    Attributes:
        windows: of the recordings.
        counts: (windows,) the weight of each, 1 or 0; None where all count.
        colour: (axes, lags) of an autoregression that the errors follow; None where they are white.
    """

    windows: Windows
    counts: Array | None = None
    colour: Array | None = None

    def without(self, windows: Array) -> Problem:
        """The problem in which some windows (a mask) do not move θ."""
        return replace(self, counts=np.where(windows, 0.0, 1.0))

    def white(self, error: Array) -> Array:
        """(samples,) or (samples, columns) errors, or their slopes, without the errors' colour."""
        if self.colour is None:
            return error
        axis, window = self.windows.axis, self.windows.window
        found = error.copy()
        for k in range(1, self.colour.shape[1] + 1):
            follows = (window[k:] == window[:-k]) & (axis[k:] == axis[:-k])
            share = self.colour[axis[k:], k - 1] * follows
            found[k:] -= share.reshape(-1, *(1,) * (error.ndim - 1)) * error[:-k]
        return np.asarray(found)

    def errors(self, predicted: Array) -> Array:
        """(samples, columns) measured less predicted, without the errors' colour."""
        return self.white(self.windows.measured[:, None] - predicted)


@dataclass(frozen=True)
class Fit:
    """A fitted model.

    Attributes:
        structure, theta: the model.
        problem: what it was fitted to.
        starts: (axes, windows) fitted velocities at the windows' first edges.
        scale: (axes,) Student's scale of the errors.
        cost: (windows,) minus the logarithm of the likelihood, up to a constant.
        units: (p,) of the parameters.
        error: (samples,) measured less predicted.
        prior: (p,) the priors' share of the normal equations, by units.
        course: of the velocities.
    """

    structure: Structure
    theta: Theta
    problem: Problem
    starts: Array
    scale: Array
    cost: Array
    units: Array
    error: Array
    prior: Array
    course: Course

    @cached_property
    def slopes(self) -> Slopes:
        """The slopes of the predictions at θ, and the normal equations made of them."""
        by = tangent(self.course, np.array([self.theta[name] for name in self.names]), self.units)
        return equations(self.problem.white(by), self.problem, self.error, self.starts, self.scale)

    @property
    def normal(self) -> Array:
        """(windows, p, p) each window's share of the normal equations, its start eliminated, by units."""
        return self.slopes.normal

    @property
    def gradient(self) -> Array:
        """(windows, p) each window's share of the gradient, its start eliminated, by units."""
        return self.slopes.gradient

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters, in the order of the normal equations."""
        return self.structure.names

    @property
    def value(self) -> float:
        """The cost of all windows and of the priors."""
        return float(self.cost.sum()) + prior_cost(self.structure, self.theta)


def prior_cost(structure: Structure, theta: Theta) -> float:
    """The cost of parameters that have a prior."""
    return float(sum(0.5 * (theta[name] / structure.prior(name)) ** 2 for name in structure.names))


def fit(
    structure: Structure,
    theta: Mapping[str, float],
    problem: Problem,
    starts: Array | None = None,
    fixed: Collection[str] = (),
    rounds: int = 12,  # nearly all fits end by themselves before
    tolerance: float = 1e-3,  # of the cost, one unit of which is a factor e of likelihood
) -> Fit:
    """Fits a structure from a θ.

    Args:
        theta: where it begins; parameters that the structure does not have are ignored.
        starts: (axes, windows) where the windows' starts begin; None for the measured ones.
        fixed: parameters that stay as they are.
    """
    windows, names = problem.windows, structure.names
    low, high = np.array([structure.bounds(name) for name in names]).reshape(-1, 2).T
    point = np.clip(np.array([theta[name] for name in names]), low, high)
    stay = np.isin(names, list(fixed))
    low, high = np.where(stay, point, low), np.where(stay, point, high)
    begin = windows.starts.copy() if starts is None else starts
    units = np.array([unit(name, structure, theta, windows) for name in names])
    counts = np.ones(windows.first.size) if problem.counts is None else problem.counts
    inverse_prior = np.array([1.0 / structure.prior(name) ** 2 for name in names])
    logarithms = np.array([is_logarithm(name) for name in names], dtype=bool)
    course = simulate(structure, point, windows, begin)
    error = problem.white(windows.measured - course.predicted)
    scale, damping = scales(error, windows), 1e-4
    enough = tolerance * max(1.0, 0.01 * np.sqrt(error.size))
    for turn in range(rounds):
        by = problem.white(tangent(course, point, units))
        slopes = equations(by, problem, error, begin, scale)
        normal = np.tensordot(counts, slopes.normal, 1) + np.diag(units**2 * inverse_prior)
        slope = counts @ slopes.gradient - point * units * inverse_prior
        now = float(counts @ slopes.cost) + 0.5 * float(point**2 @ inverse_prior)
        gain = 0.0
        for _ in range(6):
            step = bounded(
                normal + damping * np.diag(np.diag(normal) + 1e-9), slope, (low - point) / units, (high - point) / units
            )
            if abs(step @ (slope - 0.5 * normal @ step)) < 0.01 * tolerance:  # what the step promises
                break
            moved = np.where(logarithms, np.clip(step * units, -0.7, 0.7), step * units)
            new = np.clip(point + moved, low, high)
            behind = begin - np.einsum("awp,p->aw", slopes.by_theta, step) + slopes.own
            trial = simulate(structure, new, windows, behind)
            rest = problem.white(windows.measured - trial.predicted)
            after = float(counts @ costs_of(rest, scale, problem, behind)) + 0.5 * float(new**2 @ inverse_prior)
            if after < now:
                gain = now - after
                point, begin, course, error, damping = new, behind, trial, rest, max(0.1 * damping, 1e-8)
                scale = scales(rest, windows, scale)
                break
            damping *= 10.0
        if gain == 0.0 or (gain < enough and turn > 0):
            break
    found = dict(zip(names, point.tolist(), strict=True))
    cost = costs_of(error, scale, problem, begin)
    return Fit(structure, found, problem, begin, scale, cost, units, error, units**2 * inverse_prior, course)


@dataclass(frozen=True)
class Slopes:
    """Costs and normal equations at a point.

    Attributes:
        cost, error: as in `Fit`.
        normal, gradient: (windows, p, p) and (windows, p) each window's share, its start eliminated, by units.
        by_theta: (axes, windows, p) by how much a step of θ, by units, lowers each window's fitted start.
        own: (axes, windows) the step of each window's start at this θ.
    """

    cost: Array
    normal: Array
    gradient: Array
    error: Array
    by_theta: Array
    own: Array


def equations(by: Array, problem: Problem, error: Array, begin: Array, scale: Array) -> Slopes:
    """Costs and normal equations of every window from (samples, p + axes) slopes and (samples,) errors."""
    windows, p = problem.windows, by.shape[1] - len(begin)
    weight = weights(error, scale, windows)
    weighted = by * np.sqrt(weight)[:, None]
    blocks = np.stack([weighted[part].T @ weighted[part] for part in windows.samples])
    across = blocks[:, :p, p:]
    inner = blocks[:, p:, p:] + np.diag(np.minimum(windows.noise, scale) ** -2.0)
    by_theta = np.asarray(np.linalg.solve(inner, across.transpose(0, 2, 1)))
    normal = blocks[:, :p, :p] - across @ by_theta
    sums = np.stack([by[part].T @ (weight[part] * error[part]) for part in windows.samples])
    sensor = np.minimum(windows.noise, scale)  # the errors contain the sensor's noise, and more
    away = (begin - windows.starts).T / sensor**2
    own = np.linalg.solve(inner, (sums[:, p:] - away)[..., None])
    gradient = sums[:, :p] - (across @ own)[..., 0]
    return Slopes(
        costs_of(error, scale, problem, begin), normal, gradient, error, by_theta.transpose(1, 0, 2), own[..., 0].T
    )


def weights(error: Array, scale: Array, windows: Windows) -> Array:
    """Student's weights of errors, (samples,) or (samples, columns)."""
    s = scale[windows.axis].reshape(-1, *(1,) * (error.ndim - 1))
    return np.asarray((DEGREES + 1.0) / (DEGREES + (error / s) ** 2) / s**2)


def bounded(normal: Array, slope: Array, low: Array, high: Array) -> Array:
    """The step of the normal equations; parameters that a bound stops are fixed there, and the others solved again."""
    step, fixed = np.zeros(slope.size), np.zeros(slope.size, dtype=bool)
    for _ in range(4):
        free = ~fixed
        rest = slope[free] - normal[np.ix_(free, fixed)] @ step[fixed]
        step[free] = np.linalg.lstsq(normal[np.ix_(free, free)], rest, rcond=1e-12)[0]
        beyond = free & ((step < low - 1e-15) | (step > high + 1e-15))
        if not beyond.any():
            break
        step[beyond] = np.clip(step, low, high)[beyond]
        fixed |= beyond
    return np.clip(step, low, high)


def costs_of(error: Array, scale: Array, problem: Problem, begin: Array) -> Array:
    """(windows,) costs of the errors and of the fitted starts."""
    windows = problem.windows
    s = scale[windows.axis]
    of_sample = np.log(s) + 0.5 * (DEGREES + 1.0) * np.log1p((error / s) ** 2 / DEGREES)
    cost = np.bincount(windows.window, of_sample, windows.first.size)
    sensor = np.minimum(windows.noise, scale)[:, None]
    return np.asarray(cost + 0.5 * np.sum(((begin - windows.starts) / sensor) ** 2, axis=0))


def scales(error: Array, windows: Windows, before: Array | None = None) -> Array:
    """(axes,) Student's scale of the errors by maximum likelihood, at least half of their RMS.

    Without the floor, windows at rest would make outliers of those that move; Student's scale is 0.8 of the RMS.
    """
    found = []
    for i in range(len(windows.axes)):
        own = np.clip(error[windows.axis == i], -1e5, 1e5)
        rms = root_mean_square(own)
        s = max(robust_deviation(own), 0.1 * rms) if before is None else float(before[i])
        for _ in range(30 if before is None else 10):
            s = float(np.sqrt(np.mean((DEGREES + 1.0) / (DEGREES + (own / (s + 1e-12)) ** 2) * own * own)))
        found.append(max(s, 0.5 * rms) + 1e-12)
    return np.array(found)


def unit(name: str, structure: Structure, theta: Mapping[str, float], windows: Windows) -> float:
    """How far a parameter moves for a visible change; that of a row makes the usual effort of its axis."""
    if is_logarithm(name):
        return 1.0
    kind, _, rest = name.partition(":")
    if kind == "shift":
        return windows.step
    if kind == "gain":
        return 0.1
    if kind == "mass":
        a, b = rest.split("*")
        return float(np.sqrt(structure.inertia(theta, a) * structure.inertia(theta, b)))
    row = next(row for row in structure.rows if row.key == name)
    axis = row.axis
    if axis in structure.driven:
        usual = float(np.std(windows.effort(axis, "linear", Stage())))
    else:
        usual = structure.inertia(theta, axis) * float(np.std(windows.velocity[axis]))
    signals = {name: each[windows.at[:-1]] for name, each in {**windows.velocity, **windows.channel}.items()}
    for each in structure.driven:
        signals[effort_of(each)] = windows.effort(each, "linear", Stage())
    if row.follows:
        signals[f"~{row.key}"] = signals[row.follows]
    part = row.parts[0]
    size = np.sqrt(np.mean(np.square(one_by_one(part.one, signals) * one_by_one(part.other, signals))))
    return usual / max(float(size), 1e-9)
