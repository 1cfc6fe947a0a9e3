"""What others would take to predict the motion of one axis, each as something that simulates it side by side.

The Gaussian process learns d of all recorded velocities from samples of Eq. 5, with the inertia declared. pysindy and
sysidentpy get no inertia, and the recorded velocities as inputs. Each gets help that its manual does not give:
quantities divided by their deviation, the derivative smoothed over a quarter of a time scale, r|r| among the terms, a
step of a tenth of a time scale, and the threshold (or the number of terms) whose free run over the fitted recordings
errs least.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

from incsvr.numerics import Array

MOST_SAMPLES = 500
"""The Gaussian process is fitted to so many samples, evenly taken: its time grows with their cube."""
THRESHOLDS = np.geomspace(0.01, 1.0, 10)
"""Thresholds of pysindy's STLSQ, in deviations."""
TERMS = (3, 4, 5, 6, 8, 10, 12)
"""Numbers of terms that sysidentpy's FROLS is tried with."""
LAGS = 2
"""Past values of the velocity and of every input in a NARX model."""
RUNAWAY_RATIO = 10.0
"""Largest measured velocities beyond which a simulation has run away; it stays there."""


@dataclass(frozen=True, slots=True)
class Signals:
    """Recordings of one axis, one after the other, on a grid of even steps.

    Attributes:
        step: of the grid [s].
        start: (runs + 1,) index at which each run begins, and the end.
        rate: (n,) velocity at the beginning of each step [rad/s].
        torque: (n,) its mean in the step [N m].
        channels: (n,) each, in the middle of the step.
        scale: T_c, the time in which the velocity forgets itself [s].
    """

    step: float
    start: NDArray[np.intp]
    rate: Array
    torque: Array
    channels: Mapping[str, Array]
    scale: float

    def __len__(self) -> int:
        return self.rate.size

    def runs(self) -> list[slice]:
        """Each run as a slice of the grid."""
        return [slice(int(a), int(b)) for a, b in pairwise(self.start)]


class Motion(Protocol):
    """A model that simulates the velocity of an axis."""

    def simulate(self, signals: Signals) -> Array:
        """(n,) the velocity [rad/s] over all runs, each from its first measured one."""


@dataclass(frozen=True, slots=True)
class Trivial:
    """A velocity of zero, or the first one held: which part of it stays, 0 or 1."""

    kept: float

    def simulate(self, signals: Signals) -> Array:
        runs = signals.runs()
        return np.concatenate([np.full(run.stop - run.start, self.kept * signals.rate[run.start]) for run in runs])


@dataclass(frozen=True, slots=True)
class Integrated:
    """ṙ = f(r, τ, other velocities), by Runge–Kutta steps within which the inputs hold.

    Attributes:
        acceleration: f of (n,), (n,) and (n, m) [rad/s²].
        others: names of the velocities that it is given as they were measured.
        limit: beyond it a simulation has run away [rad/s].
    """

    acceleration: Callable[[Array, Array, Array], Array]
    others: tuple[str, ...]
    limit: float

    def simulate(self, signals: Signals) -> Array:
        first, size, h = _starts(signals), np.diff(signals.start), signals.step
        beside, rate = columns(signals, self.others), signals.rate[first]
        course = np.empty((size.max(), size.size))
        course[0] = rate
        for k in range(size.max() - 1):
            now = np.minimum(first + k, first + size - 1)
            torque, others = signals.torque[now], beside[now]
            k1 = self.acceleration(rate, torque, others)
            k2 = self.acceleration(rate + 0.5 * h * k1, torque, others)
            k3 = self.acceleration(rate + 0.5 * h * k2, torque, others)
            k4 = self.acceleration(rate + h * k3, torque, others)
            rate = rate + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
            rate = np.clip(np.nan_to_num(rate, nan=self.limit), -self.limit, self.limit)
            course[k + 1] = rate
        return np.concatenate([course[:count, k] for k, count in enumerate(size)])


@dataclass(frozen=True, slots=True)
class Narx:
    """A polynomial NARX model of sysidentpy.

    Attributes:
        model: the library's.
        deviation: by what velocity and inputs are divided.
        others: names of the velocities among the inputs.
        hop: cells of the grid in a step.
        limit: beyond it a simulation has run away, in deviations.
    """

    model: Any
    deviation: Array
    others: tuple[str, ...]
    hop: int
    limit: float

    def simulate(self, signals: Signals) -> Array:
        found = []
        for run in signals.runs():
            count = run.stop - run.start
            # Before a run began its velocity was its first.
            at = self.hop * np.arange(1 - LAGS, -(-(count - 1) // self.hop) + 1)
            first = np.full((LAGS, 1), signals.rate[run.start] / self.deviation[0])
            pushed = self.mean_input(signals, run.start + at, run.start, run.stop)
            with np.errstate(all="ignore"):
                course = np.nan_to_num(self.model.predict(X=pushed, y=first)[LAGS - 1 :, 0], nan=self.limit)
            course = self.deviation[0] * np.clip(course, -self.limit, self.limit)
            found.append(np.interp(np.arange(count), at[LAGS - 1 :], course))
        return np.concatenate(found)

    def mean_input(self, signals: Signals, at: NDArray[Any], begin: int, end: int) -> Array:
        """(n, m) means of what was measured over the step that begins at these cells."""
        inputs = np.column_stack([signals.torque, columns(signals, self.others)])
        cells = [np.clip(at + k, begin, end - 1) for k in range(self.hop)]
        return np.asarray(np.mean([inputs[cell] for cell in cells], axis=0) / self.deviation[1:])


Candidate = TypeVar("Candidate", Integrated, Narx)


def process(velocity: Array, damping: Array, inertia: float, names: Sequence[str]) -> Integrated:
    """d of velocities (n, d), the axis's own first, as a Gaussian process with a length for each of them."""
    chosen = np.unique(np.linspace(0, len(damping) - 1, min(MOST_SAMPLES, len(damping))).astype(int))
    scale, level = np.maximum(velocity.std(axis=0), 1e-12), max(float(damping.std()), 1e-12)
    kernel = ConstantKernel(1.0, (1e-3, 1e3)) * RBF(np.ones(scale.size), (0.1, 100.0)) + WhiteKernel(0.1, (1e-4, 1e1))
    fitted = GaussianProcessRegressor(kernel)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # a length at its bound is an answer
        fitted.fit(velocity[chosen] / scale, damping[chosen] / level)

    def acceleration(rate: Array, torque: Array, beside: Array) -> Array:
        return np.asarray((torque - level * fitted.predict(np.column_stack([rate, beside]) / scale)) / inertia)

    return Integrated(acceleration, tuple(names), RUNAWAY_RATIO * float(np.max(np.abs(velocity[:, 0]))))


def sindy(signals: Signals, others: Sequence[str]) -> Integrated:
    """SINDy with control (pysindy) over 1, x, x|x| and x y of the velocity, the torque and the other velocities."""
    import pysindy

    deviation, runs = _deviation(signals, others), signals.runs()
    inputs = np.column_stack([signals.torque, columns(signals, others)]) / deviation[1:]
    window = max(2 * round(0.125 * signals.scale / signals.step) + 1, 5)
    limit = RUNAWAY_RATIO * float(np.max(np.abs(signals.rate)))

    def fitted(threshold: float) -> Integrated:
        model = pysindy.SINDy(
            optimizer=pysindy.STLSQ(threshold=threshold, alpha=1e-6),
            feature_library=pysindy.CustomLibrary([_same, _square, _product], include_bias=True),
            differentiation_method=pysindy.SmoothedFiniteDifference(smoother_kws={"window_length": window}),
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # it warns when it selects nothing, which here is an answer
            rates = [signals.rate[run, None] / deviation[0] for run in runs]
            model.fit(rates, t=signals.step / signals.scale, u=[inputs[run] for run in runs])
        weights = np.asarray(model.coefficients(), dtype=np.float64)[0] * deviation[0] / signals.scale

        def acceleration(rate: Array, torque: Array, beside: Array) -> Array:
            # The library's terms in its order; asking the library itself takes a hundred times as long.
            z = (np.column_stack([rate, torque, beside]) / deviation).T
            pairs = [a * b for a, b in combinations(z, 2)]
            return np.asarray(weights @ np.array([np.ones_like(rate), *z, *_square(z), *pairs]))

        return Integrated(acceleration, tuple(others), limit)

    return _least(signals, [fitted(float(threshold)) for threshold in THRESHOLDS])


def frols(signals: Signals, others: Sequence[str]) -> Narx:
    """A polynomial NARX model of second degree by forward orthogonal least squares (sysidentpy)."""
    from sysidentpy.basis_function import Polynomial
    from sysidentpy.model_structure_selection import FROLS

    deviation = _deviation(signals, others)
    hop = max(round(0.1 * signals.scale / signals.step), 1)
    limit = RUNAWAY_RATIO * float(np.max(np.abs(signals.rate))) / deviation[0]
    blank = Narx(None, deviation, tuple(others), hop, limit)
    at = np.concatenate([np.arange(run.start, run.stop - hop, hop) for run in signals.runs()])
    pushed = blank.mean_input(signals, at, 0, len(signals))
    candidates, lags = [], [list(range(1, LAGS + 1))] * pushed.shape[1]
    for count in TERMS:
        basis = Polynomial(degree=2)
        model = FROLS(order_selection=False, n_terms=count, ylag=LAGS, xlag=lags, basis_function=basis)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            model.fit(X=pushed, y=signals.rate[at, None] / deviation[0])
        candidates.append(replace(blank, model=model))
    return _least(signals, candidates)


def _least(signals: Signals, candidates: Sequence[Candidate]) -> Candidate:
    """The one whose free run over the fitted recordings errs least."""
    errors = [float(np.mean((candidate.simulate(signals) - signals.rate) ** 2)) for candidate in candidates]
    return candidates[int(np.argmin(errors))]


def columns(signals: Signals, names: Sequence[str]) -> Array:
    """(n, m) what was measured of these channels."""
    return np.column_stack([np.empty((len(signals), 0)), *(signals.channels[name] for name in names)])


def _starts(signals: Signals) -> NDArray[Any]:
    return np.asarray(signals.start[:-1])


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
