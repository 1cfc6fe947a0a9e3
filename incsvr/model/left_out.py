"""Cross-validation of a fit: folds, blocks, and the gain of one model over another on excluded windows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from incsvr.model.factors import Indices
from incsvr.model.fitting import Fit, costs_of
from incsvr.model.simulation import predict
from incsvr.model.windows import Windows
from incsvr.numerics import Array


@dataclass(frozen=True, slots=True)
class Gain:
    """The gain of one model over another on windows that its fit excluded.

    Attributes:
        total: of the logarithm of the likelihood.
        rest: the total without the two best blocks: what is left of a gain that a few blocks made.
        agreeing: share of the folds in which it gains.
    """

    total: float
    rest: float
    agreeing: float


FEW_FOLDS = 8
"""Blocks of one recording or two that a fit excludes in turn: long, yet several."""


def folds(windows: Windows) -> Indices:
    """(windows,) the fold of each: its recording, or one of a few long blocks where there are fewer than three."""
    count = windows.first.size
    if len(windows.runs) >= 3:
        return windows.run
    return np.asarray(np.arange(count) * min(FEW_FOLDS, count) // count)


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


def left_out(found: Fit) -> Array:
    """(windows,) the cost of each window by the fit without its fold, which is a step of the whole fit away."""
    fold, cost = folds(found.problem.windows), found.cost.copy()
    errors, begins = _by_fold(found)
    for j, k in enumerate(np.unique(fold)):
        own = fold == k
        cost[own] = costs_of(errors[:, j], found.scale, found.problem, begins[:, j])[own]
    return cost


def left_out_errors(found: Fit) -> Array:
    """(samples,) the errors of each window by the fit without its fold."""
    windows, (errors, _) = found.problem.windows, _by_fold(found)
    which = np.unique(folds(windows), return_inverse=True)[1][windows.window]
    return np.asarray(errors[np.arange(which.size), which])


def _by_fold(found: Fit) -> tuple[Array, Array]:
    """(samples, folds) the errors of the fits without each fold, and (axes, folds, windows) their starts."""
    problem, windows = found.problem, found.problem.windows
    begins = found.starts[:, None] - np.einsum("awp,pk->akw", found.slopes.by_theta, _steps(found))
    return problem.errors(predict(found.structure, fold_parameters(found), windows, begins)), begins


def fold_parameters(found: Fit) -> Array:
    """(p, folds) θ of the fits without each fold."""
    point = np.array([found.theta[name] for name in found.names])
    return np.asarray(point[:, None] + found.units[:, None] * _steps(found))


def _steps(found: Fit) -> Array:
    """(p, folds) the step of θ, by units, that excluding each fold makes."""
    fold = folds(found.problem.windows)
    whole = found.normal.sum(axis=0) + np.diag(found.prior)
    low, high = np.array([found.structure.bounds(name) for name in found.names]).reshape(-1, 2).T
    point = np.array([found.theta[name] for name in found.names])
    steps = []
    for k in np.unique(fold):
        own = fold == k
        rest = whole - found.normal[own].sum(axis=0)
        rest += np.diag(0.01 * np.diag(whole))  # a parameter that only this fold shows stays near the whole's estimate
        step = -np.linalg.lstsq(rest, found.gradient[own].sum(axis=0), rcond=1e-10)[0]
        steps.append(np.clip(step, (low - point) / found.units, (high - point) / found.units))
    return np.stack(steps, axis=1)


def gain(by_window: Array, windows: Windows) -> Gain:
    """The gain from (windows,) that of each window."""
    block, fold = blocks(windows), folds(windows)
    by_block, by_fold = np.bincount(block, by_window), np.bincount(fold, by_window)
    present = np.bincount(fold) > 0
    total, best = float(by_block.sum()), float(np.sort(by_block)[-2:].sum())
    return Gain(total, total - best, float(np.mean(by_fold[present] > 0.0)))
