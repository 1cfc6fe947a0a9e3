"""Intervals of the effects' parameters, from the curvature of the likelihood in all of them together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from incsvr.tracing.forward.equations import Part, assumed_inertia, columns, predicted, thrust
from incsvr.tracing.forward.fit import Fit
from incsvr.tracing.forward.grid import Grid
from incsvr.tracing.forward.regression import assemble
from incsvr.tracing.statistics import NORMAL_95

Array = NDArray[np.float64]

NUDGE = 1e-3
"""Relative change of a searched parameter over which its slope is taken."""


def intervals(grid: Grid, fitted: Fit) -> list[dict[str, tuple[float, float]]]:
    """95 % interval of every parameter of every part, by the delta method."""
    regression, root = assemble(grid, fitted.model), np.sqrt(fitted.weight)
    searched = [k for k, part in enumerate(fitted.parts) if part.searched]
    slopes = [regression.whiten(fitted.noise, _slope(grid, fitted, k)) for k in searched]
    design = np.concatenate([fitted.white, *(slope[None, :] for slope in slopes)]) * root
    information = design @ design.T
    information[np.diag_indices_from(information)] *= 1.0 + 1e-9
    covariance = fitted.sigma**2 * np.linalg.pinv(information)
    declared = grid.signals.inertia
    found = []
    for k, (part, where) in enumerate(zip(fitted.parts, fitted.positions, strict=True)):
        at = list(range(where.start, where.stop))
        if k in searched:
            at.append(fitted.white.shape[0] + searched.index(k))
        own = covariance[np.ix_(at, at)]
        if part.effect.acts == "inertia":
            own = own * (assumed_inertia(declared, fitted.parts) / declared) ** 2
        found.append(_interval(part, own, declared))
    return found


def _slope(grid: Grid, fitted: Fit, k: int) -> Array:
    """(n,) change of what the k-th part takes of the torque with its searched parameter."""
    part, signals = fitted.parts[k], predicted(grid, fitted.model).signals
    step = NUDGE * max(abs(part.parameter), 1e-6)
    if part.effect.name == "drag_step":
        step = grid.signals.block
    taken = []
    for value in (part.parameter - step, part.parameter + step):
        moved = part.moved(value)
        if part.thrust:
            others = [moved if j == k else other for j, other in enumerate(fitted.parts)]
            taken.append(-thrust(grid.signals, others))
        else:
            taken.append(np.array(part.term.coefficients) @ columns(moved, signals))
    return np.asarray((taken[1] - taken[0]) / (2.0 * step))


def _interval(part: Part, covariance: Array, declared: float) -> dict[str, tuple[float, float]]:
    """Of the contract's parameters, whose slopes are taken numerically."""
    values = part.effect.parameters(part.term, declared)
    vector = [*(() if part.thrust else part.term.coefficients), *((part.parameter,) if part.searched else ())]

    def moved(at: int, by: float) -> dict[str, float]:
        changed = list(vector)
        changed[at] += by
        if part.thrust:
            return part.effect.parameters(part.moved(changed[0]).term, declared)
        count = len(part.term.coefficients)
        other = Part(part.effect, replace(part.term, coefficients=tuple(changed[:count])))
        return part.effect.parameters((other.moved(changed[-1]) if part.searched else other).term, declared)

    spans = {}
    for name, value in values.items():
        slope = np.zeros(len(vector))
        for at in range(len(vector)):
            step = 0.1 * float(np.sqrt(max(covariance[at, at], 0.0))) or 1e-9
            slope[at] = (moved(at, step)[name] - moved(at, -step)[name]) / (2.0 * step)
        half = NORMAL_95 * float(np.sqrt(max(float(slope @ covariance @ slope), 0.0)))
        spans[name] = (value - half, value + half)
    return spans
