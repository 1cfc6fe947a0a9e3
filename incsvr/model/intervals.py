"""Intervals of 95 % of fitted parameters over blocks of windows, widened by what other fits of them change."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import stdtrit

from incsvr.model.fitting import Fit, Problem, fit
from incsvr.model.left_out import blocks
from incsvr.model.series import every
from incsvr.model.structure import is_logarithm
from incsvr.model.windows import cut
from incsvr.numerics import Array


@dataclass(frozen=True, slots=True)
class Interval:
    """An estimate in its own unit, with the ends of its interval of 95 %.

    Attributes:
        value, low, high: in the parameter's unit.
        moved: the largest change in other fits, in half widths of what chance changes.
    """

    value: float
    low: float
    high: float
    moved: float


def covering(one: Mapping[str, Interval], other: Mapping[str, Interval]) -> dict[str, Interval]:
    """The intervals `one`, each so wide that it contains the other model's interval of the same parameter, too."""
    return {
        name: each
        if name not in other
        else replace(each, low=min(each.low, other[name].low), high=max(each.high, other[name].high))
        for name, each in one.items()
    }


def if_independent(found: Fit) -> Array:
    """(p, p) covariance of parameters if errors are independent, by units; thirty units wide where nothing shows it."""
    whole = found.normal.sum(axis=0) + np.diag(found.prior + 1.0 / 30.0**2)
    return np.asarray(np.linalg.inv(whole))


def covariance(found: Fit) -> Array:
    """(p, p) of the parameters, in θ's own units: over blocks of windows, no narrower than independent errors give."""
    inverse = if_independent(found)
    block = blocks(found.problem.windows)
    by_block = np.stack([np.bincount(block, found.gradient[:, j]) for j in range(found.gradient.shape[1])], axis=1)
    n = by_block.shape[0]
    spread = inverse @ (by_block.T @ by_block * n / max(n - inverse.shape[0], 1)) @ inverse
    wider = np.sqrt(np.clip(np.diag(inverse) / np.maximum(np.diag(spread), 1e-300), 1.0, 1e6))
    spread = spread * np.outer(wider, wider)
    spread += np.diag(np.maximum(np.diag(inverse) - np.diag(spread), 0.0))
    return np.asarray(spread * np.outer(found.units, found.units))


def halved(found: Fit) -> Fit:
    """The structure fitted to every second sample of every stream."""
    windows, structure = found.problem.windows, found.structure
    coarse = cut([every(run, 2) for run in windows.runs], structure, windows.step, windows.step * windows.steps)
    return fit(structure, found.theta, Problem(coarse), rounds=8)


def intervals(found: Fit, others: Sequence[Fit] = ()) -> dict[str, Interval]:
    """The interval of every parameter; what other fits move more than chance would move them widens it.

    On an axis whose inertia another fit knows within no factor, that fit explains the motion by its disturbance, so it
    says nothing there.

    Args:
        others: the fit to every second sample; the predictor, which shows motion that the simulation does not contain.
    """
    result, of_others = {}, [_known(each) for each in others]
    for name, width in zip(found.names, _widths(found), strict=True):
        at = found.theta[name]
        moves = [
            (abs(each.theta[name] - at), widths[name])
            for each, widths in zip(others, of_others, strict=True)
            if name in widths
        ]
        moved = max((change / max(by_chance(width, other), 1e-300) for change, other in moves), default=0.0)
        whole = widened(width, moves)
        ends = np.clip([at, at - whole, at + whole], *found.structure.bounds(name))
        value, low, high = (np.exp(ends) if is_logarithm(name) else ends).tolist()
        result[name] = Interval(value, low, high, moved)
    return result


def by_chance(width: float, other: float) -> float:
    """Half the width of the interval of the difference of two estimates from the same motion, from those of their own.

    It varies as their variances differ (J. A. Hausman, Specification Tests in Econometrics, 1978): what
    another fit hardly determines does not widen what this one does.
    """
    return float(np.sqrt(max(other**2 - width**2, width**2)))


def widened(width: float, moves: Sequence[tuple[float, float]]) -> float:
    """Half the width of an interval, with what other fits move it beyond chance.

    Args:
        moves: of each other fit the change of the estimate, and half the width of its own interval.
    """
    added = max((change for change, other in moves if change > by_chance(width, other)), default=0.0)
    return float(np.hypot(width, added))


def _known(found: Fit, sure: float = 0.5) -> dict[str, float]:  # half a logarithm: no wider than its value
    """The half widths of a fit's parameters, without the axes whose inertia it does not determine."""
    widths = dict(zip(found.names, _widths(found), strict=True))
    lost = {axis for axis in found.structure.axes if widths.get(f"mass:{axis}", 0.0) > sure}
    return {name: width for name, width in widths.items() if re.split("[:@]", name)[-1] not in lost}


def _widths(found: Fit) -> list[float]:
    """Half an interval of each parameter, in θ's own units."""
    return [float(each) for each in reach(found) * np.sqrt(np.maximum(np.diag(covariance(found)), 0.0))]


def reach(found: Fit, fewest: int = 4) -> float:
    """Deviations in half an interval of 95 %: Student's, because few blocks tell the deviation; with hardly more blocks
    than parameters the covariance is wide enough by itself."""
    freedom = int(blocks(found.problem.windows).max()) + 1 - len(found.names)
    return float(stdtrit(freedom, 0.975)) if freedom >= fewest else 1.96
