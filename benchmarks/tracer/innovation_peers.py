"""Peers of the tracer: what general methods for missing terms name on the same recordings.

Each gets the same help, more than its manual gives: spikes taken off the torque; every term through one Gaussian filter
with its derivative, so that filtering commutes with the model; the damping curve (a spline) projected out beforehand;
the whole vocabulary as candidate terms, the inner parameters on a small grid, a wave only where the residual has a
spectral line; thresholds by BIC. Terms that are one column (lag and delay to first order) count as a class. The target
is τ − I ṙ; with I ṙ as the target and the torque among the terms all four named fewer effects rightly.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline
from scipy.ndimage import gaussian_filter1d, median_filter

from incsvr.numerics import Array
from incsvr.tracing.run import Run, stream

PERIOD = 0.05
"""[s] of the common grid."""
CLASSES = {"torque_lag": ("torque_delay",)}
"""Effects that share a term with another: the first order of both is −T τ̇."""


@dataclass(frozen=True, slots=True)
class Terms:
    """A linear problem for sparse regression: target = columns · coefficients, all of unit deviation.

    Attributes:
        names: (m,) which effect a column means; several columns may mean the same.
        columns, target: (n, m), (n,); the damping projected out.
    """

    names: tuple[str, ...]
    columns: Array
    target: Array


def terms(run: Run, inertia: float) -> Terms:
    """The candidate terms of one recording, all filtered alike.

    Args:
        run: a recording.
        inertia: declared I [kg m²].
    """
    at_rate, rates = stream(run, run.yaw_rate)
    at_torque, torques = stream(run, run.torque)
    time = np.arange(max(at_rate[0], at_torque[0]), min(at_rate[-1], at_torque[-1]), PERIOD)
    rate = np.interp(time, at_rate, _without_spikes(rates))
    torque = np.interp(time, at_torque, _without_spikes(torques))
    channels = {name: np.interp(time, *stream(run, values)) for name, values in run.channels.items()}
    # The filter's width follows the vehicle: a tenth of the time in which the rate's autocorrelation halves.
    width = float(np.clip(0.1 * _correlation_time(rate), 0.1, 0.5) / PERIOD)
    keep = slice(round(4 * width), time.size - round(4 * width), max(round(width), 1))

    def smooth(values: Array, order: int = 0) -> Array:
        filtered = gaussian_filter1d(values, width, order=order) / PERIOD**order
        return np.asarray(filtered[keep], np.float64)

    curve = np.column_stack([smooth(column) for column in _spline(rate).T])
    residual = _without(curve, smooth(torque) - inertia * smooth(rate, 1))
    named = [(name, smooth(values)) for name, values in _raw(time, rate, torque, channels)]
    named += [("inertia", smooth(rate, 1)), ("torque_lag", smooth(torque, 1))]
    named += [("wave", part) for part in _wave(time[keep], residual)]
    columns = np.column_stack([values for _, values in named])
    columns /= np.std(columns, axis=0) + 1e-12
    columns = _without(curve, columns)
    deviation = np.std(columns, axis=0)
    # What the damping curve already says is no term of its own.
    alive = deviation > 1e-3
    return Terms(
        names=tuple(name for (name, _), use in zip(named, alive, strict=True) if use),
        columns=columns[:, alive] / deviation[alive],
        target=residual / np.std(residual),
    )


def _raw(time: Array, rate: Array, torque: Array, channels: Mapping[str, Array]) -> list[tuple[str, Array]]:
    """What can be computed before filtering, by the name of the effect."""
    scale = float(np.percentile(np.abs(torque), 99))
    span = float(time[-1] - time[0])
    since = time - time[0]
    turned = np.cumsum(rate) * PERIOD
    angle = np.unwrap(channels["heading"]) if "heading" in channels else turned
    quadratic = rate * np.abs(rate)
    found = [
        ("bias_torque", np.ones_like(rate)),
        *[("dead_zone", np.clip(torque, -half * scale, half * scale)) for half in (0.04, 0.08)],
        ("torque_asymmetry", np.minimum(torque, 0.0)),
        *[("torque_saturation", torque - np.clip(torque, -top * scale, top * scale)) for top in (0.65, 0.8)],
        ("inflow", rate * np.sqrt(np.abs(torque))),
        *[("heading_current", f(k * angle)) for k in (1, 2) for f in (np.sin, np.cos)],
        ("tether", turned - np.mean(turned)),
        *[("drag_drift", since / span * part) for part in (rate, quadratic)],
        *[("drag_step", (since > at * span) * part) for at in (0.35, 0.5, 0.65) for part in (rate, quadratic)],
        *[("memory", _lagged(rate, tau)) for tau in np.array([0.5, 1.0, 2.0]) * _correlation_time(rate)],
        ("coulomb", np.tanh(rate / (0.02 * np.percentile(np.abs(rate), 99)))),
        ("bias_drift", since / span),
    ]
    for name, values in channels.items():
        if name != "heading" and np.std(values) > 0:
            centred = values - np.mean(values)
            found += [(f"coupling:{name}", centred), (f"modulation:{name}", centred * torque)]
            found.append((f"modulation:{name}", centred * quadratic))
    return found


def stlsq(problem: Terms) -> set[int]:
    """SINDy's sequentially thresholded least squares (pysindy), the threshold of least BIC."""
    return _stlsq(problem)[0]


def _stlsq(problem: Terms) -> tuple[set[int], float]:
    import pysindy

    best, chosen, level = np.inf, set[int](), 0.1
    for threshold in np.geomspace(0.02, 0.6, 12):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # it warns when it selects nothing, which here is an answer
            fitted = pysindy.STLSQ(threshold=threshold, alpha=1e-6).fit(problem.columns, problem.target[:, None])
        support = {int(i) for i in np.flatnonzero(fitted.coef_[0])}
        score = _bic(problem, sorted(support))
        if score < best:
            best, chosen, level = score, support, float(threshold)
    return chosen, level


def ensemble(problem: Terms) -> set[int]:
    """Bagged STLSQ (pysindy): terms that 90 % of 20 resampled fits select at the same threshold."""
    import pysindy

    _, threshold = _stlsq(problem)
    legacy = np.random.get_state()  # noqa: NPY002 — pysindy draws its bags from NumPy's global generator
    np.random.seed(0)  # noqa: NPY002
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            inner = pysindy.STLSQ(threshold=threshold, alpha=1e-6)
            fitted = pysindy.EnsembleOptimizer(inner, bagging=True, n_models=20)
            fitted.fit(problem.columns, problem.target[:, None])
    finally:
        np.random.set_state(legacy)  # noqa: NPY002
    included = np.mean([np.ravel(each) != 0 for each in fitted.coef_list], axis=0)
    return {int(i) for i in np.flatnonzero(included >= 0.9)}


def forward(problem: Terms) -> set[int]:
    """Forward selection by BIC with white residuals."""
    chosen: list[int] = []
    best = _bic(problem, chosen)
    while len(chosen) < len(problem.names):
        rest = [i for i in range(len(problem.names)) if i not in chosen]
        score, index = min((_bic(problem, [*chosen, i]), i) for i in rest)
        if score >= best:
            break
        best = score
        chosen.append(index)
    return set(chosen)


def frols(problem: Terms) -> set[int]:
    """Orthogonal least squares with BIC's order (sysidentpy's FROLS), the terms as inputs of a static model."""
    from sysidentpy.basis_function import Polynomial
    from sysidentpy.model_structure_selection import FROLS

    count = len(problem.names)
    # Its inputs act one sample late by construction; so each is handed over one sample early.
    inputs = np.vstack([problem.columns[1:], problem.columns[-1:]])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model = FROLS(
            order_selection=True,
            n_info_values=min(count, 12),
            info_criteria="bic",
            model_type="NFIR",
            xlag=[[1]] * count,
            basis_function=Polynomial(degree=1),
        )
        model.fit(X=inputs, y=problem.target[:, None])
    # A regressor's code is 1000 · (input + 1) + lag, the first input being 2; 0 is the constant.
    return {int(code) // 1000 - 2 for code in np.ravel(model.final_model) if code >= 2000}


PEERS: dict[str, Callable[[Terms], set[int]]] = {
    "pysindy STLSQ": stlsq,
    "pysindy ensemble": ensemble,
    "BIC forward selection": forward,
    "sysidentpy FROLS": frols,
}


def answer(problem: Terms, selected: set[int]) -> dict[str, tuple[str, ...]]:
    """What was named, each with what it shares its term with."""
    return {problem.names[i]: CLASSES.get(problem.names[i], ()) for i in sorted(selected)}


def _bic(problem: Terms, support: list[int]) -> float:
    """n ln σ² + k ln n."""
    target, count = problem.target, problem.target.size
    left = target
    if support:
        columns = problem.columns[:, support]
        left = target - columns @ np.linalg.lstsq(columns, target, rcond=None)[0]
    return float(count * np.log(np.mean(left**2)) + len(support) * np.log(count))


def _spline(rate: Array) -> Array:
    """(n, 11) cubic B-spline with 8 intervals over the rate's range, less its value at zero: d(0) = 0."""
    low, high = np.percentile(rate, [0.1, 99.9])
    knots = np.concatenate([[low] * 3, np.linspace(low, high, 9), [high] * 3])
    curve = BSpline(knots, np.eye(knots.size - 4), 3)
    return np.asarray(curve(np.clip(rate, low, high)) - curve(np.clip(0.0, low, high)))


def _without_spikes(values: Array) -> Array:
    middle = median_filter(values, 5)
    off = np.abs(values - middle)
    return np.where(off > 6 * 1.4826 * max(float(np.median(off)), 1e-12), middle, values)


def _correlation_time(rate: Array) -> float:
    """The lag at which the rate's autocorrelation falls below a half [s]."""
    centred = rate - np.mean(rate)
    power = np.abs(np.fft.rfft(centred, 2 * rate.size)) ** 2
    correlation = np.fft.irfft(power)[: rate.size]
    return float(np.argmax(correlation < 0.5 * correlation[0])) * PERIOD


def _lagged(values: Array, time_constant: float) -> Array:
    from scipy.signal import lfilter

    keep = np.exp(-PERIOD / time_constant)
    return np.asarray(lfilter([1 - keep], [1, -keep], values))


def _without(base: Array, values: Array) -> Array:
    """What of the values (n,) or (n, m) the base's columns (n, k) do not say."""
    return np.asarray(values - base @ np.linalg.lstsq(base, values, rcond=None)[0])


def _wave(time: Array, residual: Array) -> tuple[Array, ...]:
    """Sine and cosine at the residual's strongest line, or nothing where none stands out of its neighbours at 1 %."""
    frequencies = np.fft.rfftfreq(time.size, float(time[1] - time[0]))
    power = np.abs(np.fft.rfft(residual * np.hanning(time.size))) ** 2
    # An exponential variable's median is ln 2 of its mean; the neighbours' tell the noise's colour.
    contrast = power * np.log(2) / median_filter(power, 41)
    contrast[frequencies < 1 / 60.0] = 0.0
    best = int(np.argmax(contrast))
    if contrast[best] < np.log(power.size / 0.01):
        return ()
    fine = np.linspace(frequencies[max(best - 1, 0)], frequencies[min(best + 1, frequencies.size - 1)], 41)
    strength = [abs(np.vdot(np.exp(2j * np.pi * f * time), residual)) for f in fine]
    angle = 2 * np.pi * fine[int(np.argmax(strength))] * time
    return np.sin(angle), np.cos(angle)
