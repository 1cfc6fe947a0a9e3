"""Cross-validation of a fit: folds, blocks, and the gain of one model over another on excluded windows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from incsvr.model.factors import Indices
from incsvr.model.fitting import Fit, bounded, costs_of, fit, gradients
from incsvr.model.simulation import predict
from incsvr.model.structure import is_logarithm
from incsvr.model.windows import Windows
from incsvr.numerics import Array


@dataclass(frozen=True, slots=True)
class Gain:
    """The gain of one model over another on windows that its fit excluded.

    Attributes:
        total: of the logarithm of the likelihood.
        deviations: the total in its own standard deviations, over blocks of windows.
        agreeing: share of the folds in which it gains.
    """

    total: float
    deviations: float
    agreeing: float


def folds(windows: Windows, few: int = 8) -> Indices:  # eight blocks of one recording are long, yet several
    """(windows,) the fold of each: its recording, or one of `few` long blocks where there are fewer than three."""
    count = windows.first.size
    if len(windows.runs) >= 3:
        return windows.run
    return np.asarray(np.arange(count) * min(few, count) // count)


def blocks(windows: Windows, most: int = 4) -> Indices:
    """(windows,) the block of each: neighbours of one recording, whose errors may depend on each other."""
    count = windows.first.size
    length = int(np.clip(count // 16, 1, most))  # a deviation over sixteen blocks is right within a fifth
    found, block, inside = np.zeros(count, dtype=np.intp), -1, 0
    for w in range(count):
        if w == 0 or windows.run[w] != windows.run[w - 1] or inside >= length:
            block, inside = block + 1, 0
        found[w] = block
        inside += 1
    return found


def left_out(found: Fit, exact: bool = False) -> Array:
    """(windows,) the cost of each window when its fold had no part in the fit.

    Args:
        exact: whether each fold's fit is made anew; else it is one damped Gauss–Newton step away, and simulated.
    """
    problem, windows = found.problem, found.problem.windows
    fold, cost = folds(windows), found.cost.copy()
    each = np.unique(fold)
    errors, begins = _anew(found, fold, each) if exact else _one_step(found, fold, each)
    for j, k in enumerate(each):
        own = fold == k
        cost[own] = costs_of(errors[:, j], found.scale, problem, begins[:, j])[own]
    return cost


def _one_step(found: Fit, fold: Indices, each: Indices) -> tuple[Array, Array]:
    """(samples, folds) errors and (axes, folds, windows) starts, one step without the fold away from the fit."""
    windows = found.problem.windows
    whole = found.normal.sum(axis=0) + np.diag(found.prior)
    low, high = np.array([found.structure.bounds(name) for name in found.names]).reshape(-1, 2).T
    point = np.array([found.theta[name] for name in found.names])
    columns, begins = [], []
    for k in each:
        own = fold == k
        rest = whole - found.normal[own].sum(axis=0)
        rest += np.diag(0.01 * np.diag(whole))  # a parameter that only this fold shows stays near the whole's estimate
        step = -np.linalg.lstsq(rest, found.gradient[own].sum(axis=0), rcond=1e-10)[0]
        step = np.clip(step, (low - point) / found.units, (high - point) / found.units)
        columns.append(point + step * found.units)
        begins.append(found.starts - np.einsum("awp,p->aw", found.slopes.by_theta, step))
    starts = np.stack(begins, axis=1)
    predicted = predict(found.structure, np.stack(columns, axis=1), windows, starts)
    return windows.measured[:, None] - predicted, starts


def _anew(
    found: Fit,
    fold: Indices,
    each: Indices,
    rounds: int = 3,  # with the slopes of the whole fit: each brings most folds some ten times nearer
    enough: float = 0.1,  # of the cost: gains that decide are above three
) -> tuple[Array, Array]:
    """(samples, folds) errors and (axes, folds, windows) starts of fits without each fold, all side by side.

    A fold that has not ended, because it bends the slopes, gets a round with its own slopes after the first.
    """
    problem, windows, units, slopes = found.problem, found.problem.windows, found.units, found.slopes
    low, high = np.array([found.structure.bounds(name) for name in found.names]).reshape(-1, 2).T
    logarithms = np.array([is_logarithm(name) for name in found.names], dtype=bool)
    counts = (fold[None] != each[:, None]).astype(np.float64)
    point = np.repeat(np.array([found.theta[name] for name in found.names])[:, None], each.size, axis=1)
    begin = np.repeat(found.starts[:, None], each.size, axis=1)
    normal = np.tensordot(counts, slopes.normal, 1) + np.diag(found.prior)
    normal[:, np.arange(units.size), np.arange(units.size)] *= 1.0 + 1e-4
    error = np.repeat(slopes.error[:, None], each.size, axis=1)
    share, ended = np.ones(each.size), np.zeros(each.size, dtype=bool)
    now = _costs(found, counts, point, begin, error)
    for turn in range(rounds):
        gradient, own = gradients(slopes, error, found.scale, problem, begin)
        step = np.zeros_like(point)
        for j in range(each.size):
            slope = counts[j] @ gradient[..., j] - found.prior / units * point[:, j]
            ends = [(end - point[:, j]) / units for end in (low, high)]
            step[:, j] = share[j] * bounded(normal[j], slope, *ends)
        moved = np.where(logarithms[:, None], np.clip(step * units[:, None], -0.7, 0.7), step * units[:, None])
        new = np.clip(point + moved, low[:, None], high[:, None])
        behind = begin - np.einsum("awp,pk->akw", slopes.by_theta, step) + own
        rest = windows.measured[:, None] - predict(found.structure, new, windows, behind)
        after = _costs(found, counts, new, behind, rest)
        ended, better = np.abs(after - now) < enough, after < now
        share[~better] *= 0.2
        point[:, better], begin[:, better], error[:, better] = new[:, better], behind[:, better], rest[:, better]
        now = np.where(better, after, now)
        if turn == 0:
            first, places, more = point.copy(), begin.copy(), np.where(better, 1, 2)
    for j in np.flatnonzero(~ended):
        theta = dict(zip(found.names, first[:, j].tolist(), strict=True))
        anew = fit(found.structure, theta, problem.without(counts[j] == 0.0), places[:, j], rounds=int(more[j]))
        error[:, j], begin[:, j] = anew.error, anew.starts
    return error, begin


def _costs(found: Fit, counts: Array, point: Array, begin: Array, error: Array) -> Array:
    """(folds,) the cost of each fold's fit, of the windows that it counts and the priors."""
    each = [costs_of(error[:, j], found.scale, found.problem, begin[:, j]) for j in range(len(counts))]
    return np.asarray(np.sum(counts * each, axis=1) + 0.5 * (found.prior / found.units**2) @ point**2)


def gain(by_window: Array, windows: Windows) -> Gain:
    """The gain from (windows,) that of each window."""
    block, fold = blocks(windows), folds(windows)
    by_block, by_fold = np.bincount(block, by_window), np.bincount(fold, by_window)
    n = by_block.size
    deviation = np.sqrt(np.sum((by_block - by_block.mean()) ** 2) * n / max(n - 1, 1)) + 1e-12
    present = np.bincount(fold) > 0
    return Gain(float(by_block.sum()), float(by_block.sum() / deviation), float(np.mean(by_fold[present] > 0.0)))
