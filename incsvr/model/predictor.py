"""The predictor of a model: corrected by each sample, with white innovations, it is right in open and in closed loop.

Water pushes for seconds, and a controller answers it: a simulation takes that answer for dynamics. The predictor has a
disturbance on each axis and fitted gains; what remains of its errors' colour is taken out by an autoregression
(L. Ljung, System Identification, 2nd ed., Sections 4.3 and 13.4). A measured effort has noise that never acts, by
which thrust would seem too small: where its smoothed course predicts better, that is the effort.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_toeplitz, solveh_banded

from incsvr.model.fitting import Fit, Problem, fit
from incsvr.model.scales import motion_scale, step_of, time_constants
from incsvr.model.series import duration, effort_of, period
from incsvr.model.windows import cut
from incsvr.numerics import Array, Streams

STARTS = ({"gain": 0.3, "drift": 0.1}, {"gain": 0.8, "drift": 0.5})
"""Gain of a sample [1] and of its disturbance [1/s] from which fits begin: a noisy sensor, and rough water."""


@dataclass(frozen=True)
class Predictor:
    """A model fitted as a predictor.

    Attributes:
        fit: the fit, its runs with the efforts that predict best.
        reliability: by axis, the share of its effort's variance that is no noise.
    """

    fit: Fit
    reliability: dict[str, float]


def predictor(
    plain: Fit,
    runs: Sequence[Streams],
    windows: int = 64,  # of which blocks and folds are made; each is long beside the disturbance's memory
    lags: int = 4,  # of the autoregression: more took no further colour from the missions of the world
) -> Predictor:
    """The plain model as a predictor with white innovations, from the best of several starts."""
    axes = plain.structure.axes
    sample = min(period(runs, axis) for axis in axes)
    fast = float(time_constants(plain.structure, dict(plain.theta), runs, 0.95).min())
    scale = min(motion_scale(runs, axis) for axis in axes)
    step = step_of(sample, 0.25 * min(fast, scale))
    horizon = max(duration(runs, axes[0]) / windows, 20.0 * sample)
    structure = replace(plain.structure, predictor=True)
    best, reliability = None, dict[str, float]()
    chosen = list(runs)
    for axis in (None, *structure.driven):
        tried, share = (chosen, 1.0) if axis is None else _smoothed(chosen, effort_of(axis))
        if share == 1.0 and axis is not None:
            reliability[axis] = 1.0
            continue
        problem = Problem(cut(tried, structure, step, horizon))
        fits = [
            fit(structure, {**plain.theta, **{f"{k}:{a}": v for k, v in each.items() for a in axes}}, problem)
            for each in STARTS
        ]
        found = min(fits, key=lambda each: each.value)
        better = best is None or found.value < best.value - 10.0  # the samples as they are, unless it clearly predicts
        if axis is not None:
            reliability[axis] = share if better else 1.0
        if better:
            best, chosen = found, tried
    assert best is not None
    return Predictor(whitened(whitened(best, lags), lags), reliability)


def whitened(found: Fit, lags: int = 4) -> Fit:
    """The model fitted anew to errors whose remaining colour is taken out."""
    problem = found.problem
    more = np.stack([_autoregression(found, i, lags) for i in range(len(problem.windows.axes))])
    colour = more if problem.colour is None else problem.colour + more
    return fit(found.structure, found.theta, replace(problem, colour=colour), found.starts)


def _autoregression(found: Fit, axis: int, lags: int) -> Array:
    """(lags,) of the errors of an axis, by the equations of Yule and Walker."""
    windows = found.problem.windows
    own = windows.axis == axis
    error = np.clip(found.error[own] / found.scale[axis], -4.0, 4.0)
    window = windows.window[own]
    products = [np.sum((error[k:] * error[: error.size - k])[window[k:] == window[: window.size - k]])
                for k in range(lags + 1)]  # fmt: skip
    return np.asarray(solve_toeplitz(np.array(products[:-1]), np.array(products[1:])))


def _smoothed(runs: Sequence[Streams], name: str) -> tuple[list[Streams], float]:
    """The runs with an effort as its own samples on both sides expect it, and the share of its variance that acts.

    A level that walks at random under white noise: the variances follow from the effort's differences (A. C. Harvey,
    Forecasting, Structural Time Series Models and the Kalman Filter, Section 2.4). A command shows no noise.
    """
    change = np.concatenate([np.diff(run[name][1]) for run in runs])
    white = max(-float(np.mean(change[1:] * change[:-1])), 0.0)
    walk = float(np.var(change)) - 2.0 * white
    whole = float(np.var(np.concatenate([run[name][1] for run in runs])))
    if white <= 1e-3 * max(walk, 0.0) or whole <= 0.0:
        return list(runs), 1.0
    ratio = white / max(walk, 1e-6 * white)
    found = []
    for run in runs:
        t, u = run[name]
        banded = np.empty((2, u.size))
        banded[0], banded[1] = -ratio, 1.0 + 2.0 * ratio
        banded[1, [0, -1]] = 1.0 + ratio
        found.append({**run, name: (t, np.asarray(solveh_banded(banded, u)))})
    return found, max(1.0 - white / whole, 0.0)
