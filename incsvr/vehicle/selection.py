"""The selection of couplings, lags and entries of M: each must predict windows that its fit did not see.

Candidates are scored in one Gauss–Newton step; the best few are fitted. Parts of the recordings are then left out in
turns, in the linear model about the fit, and the candidate that predicts them best is added if it pays.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array
from incsvr.plant.terms import CROSS, EFFORT, PRODUCT, SQUARE
from incsvr.vehicle.fitting import PRIOR_SCALES, Fit, Windows, fit, losses, normal_equations
from incsvr.vehicle.scales import Candidate, Extension, Scales

COUPLINGS = (CROSS, PRODUCT, SQUARE, EFFORT)
"""Kinds of terms that a hull may have, and that are taken out where data do not need them."""
LEADS = 3
"""Candidates that are fitted in each round."""
MAX_ADDED = 12
"""Candidates that are added at most: twelve minutes hold no more."""
FOLDS = 8
"""Parts that are left out in turns; whole runs where there are at least three."""
MIN_EVIDENCE = 6.0
"""Fall of −2 log likelihood on the parts left out that a candidate must bring, beyond 2 ln(candidates)."""
BLOCK_WINDOWS = 4
"""Windows whose falls count as one number: what disturbs a vehicle outlasts a window."""
STEADY = 2.0
"""Standard errors by which that fall must differ from zero over blocks."""
RELEVANT = 0.01
"""Relative fall of the squared error that a candidate must bring: nobody would see less."""
STEPS_OF_A_TRIAL = 5
"""Gauss–Newton steps for a candidate: it starts from a fitted model."""


def extended(windows: Windows, fitted: Fit, candidates: Sequence[Candidate], scales: Scales) -> Fit:
    """The model with every candidate that pays, and without those that no longer do.

    Args:
        windows: what is predicted.
        fitted: the model to begin with.
        candidates: terms, names of axes whose effort may lag, and pairs of M.
        scales: of all parameters.
    """
    folds = parts(windows)
    open_candidates = list(candidates)
    loss = LeftOut.of(fitted, folds, scales).losses(fitted.variance)
    price = MIN_EVIDENCE + 2.0 * float(np.log(max(len(open_candidates), 1)))
    for _ in range(MAX_ADDED):
        ranked = _ranked(windows, fitted, open_candidates, scales)
        best: tuple[float, Candidate, Fit] | None = None
        for candidate, extension in ranked[:LEADS]:
            bounds = scales.bounds(extension.structure)
            tried = fit(windows, extension.structure, extension.start, extension.scale, bounds, STEPS_OF_A_TRIAL)
            tried_loss = LeftOut.of(tried, folds, scales).losses(fitted.variance)
            gain = _gain(loss, tried_loss)
            smaller = 1.0 - _squares(tried, fitted.variance) / _squares(fitted, fitted.variance)
            if gain > price and smaller > RELEVANT and (best is None or gain > best[0]):
                best = gain, candidate, tried
        if best is None:
            break
        _, candidate, fitted = best
        loss = LeftOut.of(fitted, folds, scales).losses(fitted.variance)
        open_candidates.remove(candidate)
    return fitted


def reduced(windows: Windows, fitted: Fit, scales: Scales) -> Fit:
    """The model without the couplings that the parts left out do not need.

    They are taken out one after the other in the linear model about the fit, the least useful first; what stays is
    fitted anew. Where that fit ends in a worse place than the linear model promised, nothing is taken out.
    """
    structure = fitted.structure
    first = len(structure.mass)
    folds = parts(windows)
    removable = [first + k for k, term in enumerate(structure.terms) if term.kind in COUPLINGS]
    removable += [k for k, (one, other) in enumerate(structure.mass) if one != other]
    removed: list[int] = []
    linear = LeftOut.of(fitted, folds, scales)
    loss = whole = linear.losses(fitted.variance)
    while removable:
        tried = linear.losses_without(fitted.variance, [[*removed, k] for k in removable])
        least = int(np.argmin(tried.sum(axis=1)))
        if _gain(tried[least], loss) > MIN_EVIDENCE:
            break
        removed.append(removable.pop(least))
        loss = tried[least]
    kept = [k for k in range(structure.size) if k not in removed]
    smaller = structure.only(kept)
    again = fit(windows, smaller, fitted.parameters[kept], fitted.scale[kept], scales.bounds(smaller))
    worse = LeftOut.of(again, folds, scales).losses(fitted.variance).sum() - whole.sum()
    return fitted if worse > MIN_EVIDENCE * max(len(removed), 1) else again


def parts(windows: Windows) -> NDArray[np.intp]:
    """(windows,) the part that each window belongs to: runs where there are three, else stretches of equal length."""
    run = np.searchsorted(windows.motion.start, windows.first, side="right") - 1
    if np.unique(run).size >= 3:
        return np.unique(run, return_inverse=True)[1].astype(np.intp)
    return (np.arange(run.size) * FOLDS // max(run.size, 1)).astype(np.intp)


@dataclass(frozen=True, slots=True)
class LeftOut:
    """A fit's linear model, with each part of the windows left out in turns.

    Attributes:
        fitted: the fit.
        inside: the windows of each part.
        slopes: (size, windows · cells · axes) the slopes of each part's errors.
        normal, gradient: JᵀWJ and JᵀWe of each part, (parts, size, size) and (parts, size).
        bounds: lower and upper (size,) of the parameters.
    """

    fitted: Fit
    inside: list[NDArray[np.intp]]
    slopes: list[Array]
    normal: Array
    gradient: Array
    bounds: tuple[Array, Array]

    @staticmethod
    def of(fitted: Fit, folds: NDArray[np.intp], scales: Scales) -> LeftOut:
        """The linear model of a fit whose windows belong to these parts."""
        inside = [np.flatnonzero(folds == part) for part in np.unique(folds)]
        slopes = [fitted.slope[:, part] for part in inside]
        equations = [
            normal_equations(slope, fitted.error[part], fitted.weight[part])
            for part, slope in zip(inside, slopes, strict=True)
        ]
        normal, gradient = (np.stack(each) for each in zip(*equations, strict=True))
        flat = [slope.reshape(slope.shape[0], -1) for slope in slopes]
        return LeftOut(fitted, inside, flat, normal, gradient, scales.bounds(fitted.structure))

    def losses(self, variance: Array) -> Array:
        """(windows,) losses of each part under the parameters that the other parts give.

        Args:
            variance: (axes,) of the errors: the same for models that are compared.
        """
        return np.asarray(self.losses_without(variance, [()])[0])

    def losses_without(self, variance: Array, without: Sequence[Sequence[int]]) -> Array:
        """(models, windows) the losses of several models, each without some parameters, which are zero."""
        fitted = self.fitted
        normal, gradient = self.normal.sum(axis=0), self.gradient.sum(axis=0)
        found = np.empty((len(without), fitted.error.shape[0]))
        for k, part in enumerate(self.inside):
            rest, pull = normal - self.normal[k], self.gradient[k] - gradient
            steps = np.stack([self._step(rest, pull, each) for each in without])
            moved = (steps @ self.slopes[k]).reshape(len(without), *fitted.error[part].shape)
            found[:, part] = losses(fitted.error[part] + moved, variance)
        return found

    def _step(self, normal: Array, pull: Array, without: Sequence[int]) -> Array:
        """(size,) from the fitted parameters to those that normal equations give where some parameters are zero."""
        fitted, (low, high) = self.fitted, self.bounds
        free = np.setdiff1d(np.arange(fitted.parameters.size), np.asarray(without, dtype=np.intp))
        step = np.zeros(fitted.parameters.size)
        step[list(without)] = -fitted.parameters[list(without)]
        force = pull - normal @ step
        ridge = np.diag(1.0 / (PRIOR_SCALES * fitted.scale[free]) ** 2)
        step[free] = np.linalg.solve(normal[np.ix_(free, free)] + ridge, force[free])
        step[free] = (np.clip(fitted.parameters + step, low, high) - fitted.parameters)[free]
        return step


def _gain(before: Array, after: Array) -> float:
    """The fall of the losses, or −∞ where it is not steady over blocks of windows."""
    fall = before - after
    block = np.arange(fall.size) // BLOCK_WINDOWS
    sums = np.bincount(block, weights=fall)
    error = float(np.std(sums, ddof=1) * np.sqrt(sums.size)) if sums.size > 1 else float("inf")
    total = float(fall.sum())
    return total if total > STEADY * error else float("-inf")


def _squares(fitted: Fit, variance: Array) -> float:
    """The weighted sum of squared errors, in variances of the axes' velocities."""
    return float(np.sum(np.mean(fitted.error**2, axis=(0, 1)) / variance))


def _ranked(
    windows: Windows, fitted: Fit, candidates: Sequence[Candidate], scales: Scales
) -> list[tuple[Candidate, Extension]]:
    """The candidates that may fall in one step, the best first."""
    normal, gradient = normal_equations(fitted.slope, fitted.error, fitted.weight)
    inverse = np.linalg.pinv(normal, hermitian=True)
    extensions = [(candidate, scales.extension(fitted, candidate)) for candidate in candidates]
    ranked = []
    for candidate, extension in extensions:
        moved = extension.start.copy()
        shift = 1e-3 * extension.scale[extension.place]
        moved[extension.place] += shift
        pair = windows.errors(extension.structure, np.stack([extension.start, moved]))
        slope = ((pair[1] - pair[0]) / shift)[None]
        own, pull = normal_equations(slope, fitted.error, fitted.weight)
        rows = fitted.slope.reshape(fitted.slope.shape[0], -1)
        weights = np.broadcast_to(fitted.weight[:, None, :] / fitted.error.shape[1], fitted.error.shape).ravel()
        across = (rows * weights) @ slope.ravel()
        left = float(own[0, 0] - across @ inverse @ across)
        force = float(pull[0] - across @ inverse @ gradient)
        if left > 1e-9 * float(own[0, 0]):
            ranked.append((force**2 / left, candidate, extension))
    ranked.sort(key=lambda row: -row[0])
    return [(candidate, extension) for _, candidate, extension in ranked]
