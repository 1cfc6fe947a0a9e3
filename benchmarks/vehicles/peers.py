"""What others would take to predict the motion of one axis, each as something that simulates it.

The methods that are told the inertia learn d from samples of Eq. 5: least squares, recursive least squares, the
adaptive identifier and our learner a curve d(r), the Gaussian process d of all velocities that are recorded. pysindy
and sysidentpy are told no inertia and take the recorded velocities as inputs. Each gets help that its manual does not
give: quantities divided by their deviation, the derivative smoothed over a quarter of a time scale, r|r| among the
terms, a step of a tenth of a time scale, and the threshold (or the number of terms) whose free run over the fitted
recordings errs least.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from typing import TypeVar

import numpy as np

from benchmarks.vehicles.gaussian_process import gaussian_process
from benchmarks.vehicles.motion import LAGS, Integrated, Narx, columns
from incsvr.effects import Signals
from incsvr.numerics import Array

MOST_SAMPLES = 500
"""The Gaussian process is fitted to so many samples, evenly taken: its time grows with their cube."""
THRESHOLDS = np.geomspace(0.01, 1.0, 10)
"""Thresholds of pysindy's STLSQ, in deviations."""
TERMS = (3, 4, 5, 6, 8, 10, 12)
"""Numbers of terms that sysidentpy's FROLS is tried with."""
RUNAWAY_RATIO = 10.0
"""Largest measured velocities beyond which a simulation has run away; it stays there."""
Candidate = TypeVar("Candidate", Integrated, Narx)


def process(rate: Array, others: Array, damping: Array, inertia: float, names: Sequence[str]) -> Integrated:
    """d(r, other velocities) as a Gaussian process of a few samples."""
    drag = gaussian_process(np.column_stack([rate, others]), damping, MOST_SAMPLES)

    def acceleration(now: Array, torque: Array, beside: Array) -> Array:
        return np.asarray((torque - drag(np.column_stack([now, beside]))) / inertia)

    return Integrated(acceleration, tuple(names), RUNAWAY_RATIO * float(np.max(np.abs(rate))))


def sindy(signals: Signals, others: Sequence[str]) -> Integrated:
    """SINDy with control (pysindy) over 1, x, x|x| and x y of the velocity, the torque and the other velocities."""
    import pysindy

    deviation = _deviation(signals, others)
    inputs = np.column_stack([signals.torque, columns(signals, others)]) / deviation[1:]
    runs = signals.runs()
    window = max(2 * round(0.125 * signals.scale / signals.step) + 1, 5)
    limit = RUNAWAY_RATIO * float(np.max(np.abs(signals.rate)))

    def fitted(threshold: float) -> Integrated:
        library = pysindy.CustomLibrary([_same, _square, _product], include_bias=True)
        model = pysindy.SINDy(
            optimizer=pysindy.STLSQ(threshold=threshold, alpha=1e-6),
            feature_library=library,
            differentiation_method=pysindy.SmoothedFiniteDifference(smoother_kws={"window_length": window}),
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # it warns when it selects nothing, which here is an answer
            model.fit(
                [signals.rate[run, None] / deviation[0] for run in runs],
                t=signals.step / signals.scale,
                u=[inputs[run] for run in runs],
            )

        weights = np.asarray(model.coefficients(), dtype=np.float64)[0] * deviation[0] / signals.scale

        def acceleration(rate: Array, torque: Array, beside: Array) -> Array:
            # The library's terms in its order; asking the library itself takes a hundred times as long.
            z = (np.column_stack([rate, torque, beside]) / deviation).T
            pairs = [a * b for a, b in combinations(z, 2)]
            rise: Array = weights @ np.array([np.ones_like(rate), *z, *_square(z), *pairs])
            return rise

        return Integrated(acceleration, tuple(others), limit)

    return _least(signals, [fitted(float(threshold)) for threshold in THRESHOLDS])


def frols(signals: Signals, others: Sequence[str]) -> Narx:
    """A polynomial NARX model of second degree by forward orthogonal least squares (sysidentpy)."""
    from sysidentpy.basis_function import Polynomial
    from sysidentpy.model_structure_selection import FROLS

    deviation = _deviation(signals, others)
    hop = max(round(0.1 * signals.scale / signals.step), 1)
    blank = Narx(np.zeros((0, 2), dtype=np.intp), np.zeros(0), deviation, tuple(others), hop, 0.0)
    blank = replace(blank, limit=RUNAWAY_RATIO * float(np.max(np.abs(signals.rate))) / deviation[0])
    inputs = np.column_stack([signals.torque, columns(signals, others)])
    at = np.concatenate([np.arange(run.start, run.stop - hop, hop) for run in signals.runs()])
    pushed = blank.mean_input(inputs, at, np.zeros_like(at), np.full_like(at, len(signals)))
    measured = signals.rate[at, None] / deviation[0]
    candidates = []
    for count in TERMS:
        model = FROLS(
            order_selection=False,
            n_terms=count,
            ylag=LAGS,
            xlag=[list(range(1, LAGS + 1))] * pushed.shape[1],
            basis_function=Polynomial(degree=2),
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            model.fit(X=pushed, y=measured)
        terms = np.asarray(model.final_model, dtype=np.intp)
        candidates.append(replace(blank, terms=terms, theta=np.ravel(model.theta)))
    return _least(signals, candidates)


def _least(signals: Signals, candidates: Sequence[Candidate]) -> Candidate:
    """The one whose free run over the fitted recordings errs least."""
    errors = [float(np.mean((candidate.simulate(signals)[1] - signals.rate) ** 2)) for candidate in candidates]
    return candidates[int(np.argmin(errors))]


def _same(x: Array) -> Array:
    return x


def _square(x: Array) -> Array:
    """x|x|."""
    return np.asarray(x * np.abs(x))


def _product(x: Array, y: Array) -> Array:
    return x * y


def _deviation(signals: Signals, others: Sequence[str]) -> Array:
    """Of the velocity, the torque and the other velocities."""
    every = np.column_stack([signals.rate, signals.torque, columns(signals, others)])
    return np.asarray(np.maximum(np.std(every, axis=0), 1e-12))
