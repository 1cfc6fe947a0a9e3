"""The predictor of a model: corrected by each sample, with white innovations, it is right in open and in closed loop.

Water pushes for seconds, and a controller answers it: a simulation takes that answer for dynamics. The predictor has a
disturbance on each axis, which fades, and fitted gains; what remains of its errors' colour is taken out by an
autoregression (L. Ljung, System Identification, 2nd ed., Sections 4.3 and 13.4). A measured effort has noise that never
acts, by which thrust would seem too small: where its smoothed course predicts better, that is the effort.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from incsvr.model.efforts import WAYS
from incsvr.model.fitting import Fit, Problem, fit
from incsvr.model.scales import fastest, step_of
from incsvr.model.series import duration, effort_of, noise, period, values
from incsvr.model.structure import OF_PREDICTOR, Structure, Theta
from incsvr.model.windows import cut
from incsvr.numerics import Array, Streams, robust_deviation
from incsvr.numerics.lapack import banded

STARTS = ((0.3, 0.02), (0.9, 0.3))
"""Gains of a sample on the velocity and on the disturbance, per sample, of a noisy sensor and in rough water."""
WALKS = ((1, 0.1), (1, 0.3), (1, 1.0), (2, 0.03), (2, 0.1), (2, 0.3))
"""How an effort may walk: in its level, as steps do, or in its slope, as ramps and waves do; how far from sample to
sample, in deviations of its noise. The best predictor decides."""


@dataclass(frozen=True)
class Predictor:
    """A model fitted as a predictor.

    Attributes:
        fit: the fit, its runs with the efforts that predict best.
        reliability: by axis, the share of its effort's variance that is no noise.
    """

    fit: Fit
    reliability: Mapping[str, float]


def predictor(
    plain: Fit,
    runs: Sequence[Streams],
    windows: int = 64,  # at least, of which blocks and folds are made
    samples: float = 150.0,  # in a window at most: a disturbance fades long before, and windows side by side are faster
    lags: int = 4,  # of the autoregression: more took no further colour from the missions of the world
) -> Predictor:
    """The plain model as a predictor with white innovations, from the best of several starts."""
    axes = plain.structure.axes
    fast = fastest(plain.structure, plain.theta, runs)
    sample = min(period(runs, axis) for axis in axes)
    step = step_of(sample, 0.25 * fast, 0.2)
    horizon = max(min(duration(runs, axes[0]) / windows, samples * sample), 20.0 * sample)
    structure = replace(plain.structure, predictor=True)
    shifts = {name: 0.0 for name in structure.names if name.startswith("shift")}
    begins = [{**plain.theta, **shifts, **_gains(axes, gain, drift / sample)} for gain, drift in STARTS]
    best = _ended(_begun(structure, begins, runs, step, horizon))
    reliability = dict.fromkeys(structure.driven, 1.0)
    noisy = [axis for axis in structure.driven if _is_noisy(runs, effort_of(axis))]
    if noisy:
        smoothed = [_smoothed(runs, [effort_of(axis) for axis in noisy], *walk) for walk in WALKS]
        way, begins = (best.structure.ways[noisy[0]],), [{**best.theta, **shifts}]
        trials = [_begun(structure, begins, acting, step, horizon, way) for acting, _ in smoothed]
        which = int(np.argmin([each.value for each in trials]))
        again = _begun(structure, begins, smoothed[which][0], step, horizon)  # noise had hidden the way
        found = _ended(min(trials[which], again, key=lambda each: each.value))
        if found.value < best.value - 10.0:  # the samples as they are, unless others clearly predict better
            best = found
            reliability |= dict(zip(noisy, smoothed[which][1], strict=True))
    return Predictor(converged(best, lags), reliability)


def converged(
    found: Fit,
    lags: int = 4,
    least: float = 2.0,  # of the logarithm of the likelihood: less decides nothing
    rounds: int = 5,  # in which the colour of vehicles with an effect came to rest
) -> Fit:
    """The model fitted anew to errors whose remaining colour is taken out, until that gains no more than `least`."""
    found = whitened(found, lags) if found.problem.colour is None else found
    for _ in range(rounds):
        new = whitened(found, lags)
        if new.value > found.value - least:
            return min(new, found, key=lambda each: each.value)
        found = new
    return found


def anew(structure: Structure, theta: Theta, found: Fit) -> Fit:
    """A model as a predictor from the best of the usual starts of its gains, whatever colour another fit has left."""
    problem, axes = replace(found.problem, colour=None), structure.axes
    sample = min(period(problem.windows.runs, axis) for axis in axes)
    begun = [
        fit(structure, {**theta, **_gains(axes, gain, drift / sample)}, problem, found.starts, rounds=4)
        for gain, drift in STARTS
    ]
    return converged(_ended(min(begun, key=lambda each: each.value)))


def _begun(
    structure: Structure,
    begins: Sequence[Theta],
    runs: Sequence[Streams],
    step: float,
    horizon: float,
    ways: Sequence[str] = WAYS,
) -> Fit:
    """The best of the predictors from all starts and ways after a few rounds.

    The start of the first way is that of the others, because neither sensor nor water depend on the way.
    """
    found = list[Fit]()
    for way in ways:
        other = replace(structure, ways=dict.fromkeys(structure.driven, way))
        problem = Problem(cut(runs, other, step, horizon))
        tried = [fit(other, each, problem, rounds=4) for each in begins]
        best = min(range(len(tried)), key=lambda k: tried[k].value)
        begins, found = [begins[best]], [*found, tried[best]]
    return min(found, key=lambda each: each.value)


def _ended(begun: Fit) -> Fit:
    """The fit, gone on with to its end."""
    return fit(begun.structure, begun.theta, begun.problem, begun.starts)


def _is_noisy(runs: Sequence[Streams], name: str) -> bool:
    """Whether an effort has white noise; a command, which holds or runs on lines, has none."""
    third = np.concatenate([np.diff(run[name][1], 3) for run in runs])
    return third.size > 0 and robust_deviation(third) > 1e-3 * float(np.std(values(runs, name)))


def _gains(axes: Sequence[str], gain: float, drift: float) -> dict[str, float]:
    """The parameters of every axis's predictor, as in θ; `drift` [1/s], which a disturbance outlives ten times."""
    own = {"gain": gain, "drift": float(np.log(drift)), "fade": float(np.log(0.1 * drift))}
    return {f"{kind}:{axis}": own[kind] for kind in OF_PREDICTOR for axis in axes}


def whitened(found: Fit, lags: int = 4) -> Fit:
    """The model fitted anew to errors whose remaining colour is taken out."""
    problem = found.problem
    more = np.stack([_autoregression(found, i, lags) for i in range(len(problem.windows.axes))])
    colour = more if problem.colour is None else problem.colour + more
    return fit(found.structure, found.theta, replace(problem, colour=colour), found.starts)


def frequencies(found: Fit, axis: int, most: int = 2, cycles: float = 8.0) -> list[float]:
    """The clearest frequencies of an axis's errors [rad/s], each of at least some cycles in the longest recording."""
    windows = found.problem.windows
    own = windows.axis == axis
    run = windows.run[windows.window]
    longest = int(np.argmax(np.bincount(run[own])))
    own &= run == longest
    grid = windows.grids[longest]
    at = windows.step * (windows.first[windows.window[own]] - grid.first + windows.cell[own] + windows.part[own])
    error = np.clip(found.error[own] / found.scale[axis], -4.0, 4.0)
    even = np.interp(np.linspace(at[0], at[-1], at.size), at, error)
    power = np.abs(np.fft.rfft(even * np.hanning(even.size), 4 * even.size))
    each = 2.0 * np.pi / (4.0 * (at[-1] - at[0]))  # [rad/s] between two lines
    power[: int(4 * cycles)] = 0.0
    result = []
    for _ in range(most):
        peak = int(np.argmax(power))
        result.append(peak * each)
        power[max(peak - 12, 0) : peak + 13] = 0.0
    return result


def _autoregression(found: Fit, axis: int, lags: int) -> Array:
    """(lags,) of the errors of an axis, by the equations of Yule and Walker."""
    windows = found.problem.windows
    own = windows.axis == axis
    error = np.clip(found.error[own] / found.scale[axis], -4.0, 4.0)
    window = windows.window[own]
    products = [np.sum((error[k:] * error[: error.size - k])[window[k:] == window[: window.size - k]])
                for k in range(lags + 1)]  # fmt: skip
    apart = np.abs(np.subtract.outer(np.arange(lags), np.arange(lags)))
    return np.asarray(np.linalg.solve(np.array(products)[apart], products[1:]))


def _smoothed(
    runs: Sequence[Streams], names: Sequence[str], order: int, ratio: float
) -> tuple[list[Streams], list[float]]:
    """The runs with efforts as their own samples on both sides expect them, and the share of each's variance that acts.

    Args:
        order: 1 where its level walks, 2 where its slope does.
        ratio: how far that usually walks from sample to sample, in deviations of the effort's noise.
    """
    found, shares = [dict(run) for run in runs], np.ones((len(runs), len(names)))
    for run, each in zip(found, shares, strict=True):
        for k, name in enumerate(names):
            t, u = run[name]
            white = noise(u)
            level = _level(u, white, ratio * white, order)
            run[name] = (t, level)
            each[k] = np.var(level) / (np.var(level) + white**2)
    return list(found), shares.min(axis=0).tolist()


def _level(value: Array, noise: float, walk: float, order: int, rounds: int = 15) -> Array:
    """(n,) a level whose differences of an order walk at random under noise, both with the tails of Student's t: steps
    or corners stay, spikes do not.

    A. C. Harvey, Forecasting, Structural Time Series Models and the Kalman Filter, Section 2.3.
    """
    level = value.copy()
    middle = np.median([value[:-2], value[1:-1], value[2:]], axis=0)
    level[1:-1] = middle
    part = np.diff(np.eye(order + 1), order, axis=0)[0]  # of one difference: (−1, 1) or (1, −2, 1)
    for _ in range(rounds):
        of_value = 5.0 / (4.0 + ((value - level) / noise) ** 2) / noise**2
        of_change = 5.0 / (4.0 + (np.diff(level, order) / walk) ** 2) / walk**2
        band = np.zeros((order + 1, value.size))
        band[0] = of_value
        for i in range(order + 1):
            for j in range(i + 1):
                band[i - j, j : j + of_change.size] += part[i] * part[j] * of_change
        level = banded(band, of_value * value)
    return np.asarray(level)
