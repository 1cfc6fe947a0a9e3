"""Models of one axis' motion that simulate it over spans of recordings, side by side, as `TracedModel` does."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from incsvr.effects import Signals
from incsvr.numerics import Array

Course = tuple[NDArray[Any], Array]
"""Indices into the cells of the spans, one after the other, and the simulated velocity there [rad/s]."""
LAGS = 2
"""Past values of the velocity and of every input in a NARX model."""


class Motion(Protocol):
    """A model that simulates the velocity of an axis."""

    def simulate(self, signals: Signals, spans: Sequence[slice] | None = None) -> Course:
        """As `incsvr.tracing.model.TracedModel.simulate`."""


@dataclass(frozen=True, slots=True)
class Trivial:
    """A velocity of zero, or the first one held.

    Attributes:
        kept: which part of the first velocity stays, 0 or 1.
    """

    kept: float

    def simulate(self, signals: Signals, spans: Sequence[slice] | None = None) -> Course:
        pieces = signals.runs() if spans is None else spans
        held = [np.full(piece.stop - piece.start, self.kept * signals.rate[piece.start]) for piece in pieces]
        simulated = np.concatenate(held)
        return np.arange(simulated.size), simulated


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

    def simulate(self, signals: Signals, spans: Sequence[slice] | None = None) -> Course:
        pieces = signals.runs() if spans is None else spans
        first, size, h = _starts(pieces), _sizes(pieces), signals.step
        beside = columns(signals, self.others)
        rate = signals.rate[first]
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
        simulated = np.concatenate([course[:count, k] for k, count in enumerate(size)])
        return np.arange(simulated.size), simulated


@dataclass(frozen=True, slots=True)
class Narx:
    """A polynomial NARX model of sysidentpy, its terms evaluated over all spans at once.

    Attributes:
        terms: sysidentpy's codes, (terms, degree): 1000 (j + 1) + lag of quantity j, of which the first is the
            velocity; 0 stands for 1.
        theta: (terms,) coefficients.
        deviation: by what velocity and inputs are divided.
        others: names of the velocities among the inputs.
        hop: cells of the grid in a step.
        limit: beyond it a simulation has run away, in deviations.
    """

    terms: NDArray[np.intp]
    theta: Array
    deviation: Array
    others: tuple[str, ...]
    hop: int
    limit: float

    def simulate(self, signals: Signals, spans: Sequence[slice] | None = None) -> Course:
        pieces = signals.runs() if spans is None else spans
        first, size = _starts(pieces), _sizes(pieces)
        run = np.searchsorted(signals.start, first, side="right") - 1
        begin, end = signals.start[run], signals.start[run + 1]
        inputs = np.column_stack([signals.torque, columns(signals, self.others)])
        steps = -(-(int(size.max()) - 1) // self.hop)
        # What was measured before the span began; before the recording began, its first value.
        before = [np.maximum(first - lag * self.hop, begin) for lag in range(LAGS - 1, 0, -1)]
        course = [signals.rate[at] / self.deviation[0] for at in (*before, first)]
        driven = [self.mean_input(inputs, first + k * self.hop, begin, end) for k in range(1 - LAGS, steps)]
        for k in range(steps):
            past = [course[k + LAGS - 1 - lag] for lag in range(LAGS)]
            pushed = [driven[k + LAGS - 1 - lag] for lag in range(LAGS)]
            new = np.zeros(first.size)
            for codes, weight in zip(self.terms, self.theta, strict=True):
                term = np.full(first.size, weight)
                for code in codes[codes > 0]:
                    which, lag = divmod(int(code), 1000)
                    term = term * (past[lag - 1] if which == 1 else pushed[lag - 1][:, which - 2])
                new += term
            course.append(np.clip(np.nan_to_num(new, nan=self.limit), -self.limit, self.limit))
        table = self.deviation[0] * np.array(course[LAGS - 1 :])
        at = np.arange(steps + 1) * self.hop
        parts = [np.interp(np.arange(count), at, table[:, k]) for k, count in enumerate(size)]
        simulated = np.concatenate(parts)
        return np.arange(simulated.size), simulated

    def mean_input(self, inputs: Array, at: NDArray[np.intp], begin: NDArray[np.intp], end: NDArray[np.intp]) -> Array:
        """(spans, m) means over the step that begins at these cells, of what was measured."""
        cells = [np.clip(at + k, begin, end - 1) for k in range(self.hop)]
        return np.asarray(np.mean([inputs[cell] for cell in cells], axis=0) / self.deviation[1:])


def columns(signals: Signals, names: Sequence[str]) -> Array:
    """(n, m) what was measured of these channels."""
    return np.column_stack([np.empty((len(signals), 0)), *(signals.channels[name] for name in names)])


def _starts(pieces: Sequence[slice]) -> NDArray[np.intp]:
    return np.array([piece.start for piece in pieces], dtype=np.intp)


def _sizes(pieces: Sequence[slice]) -> NDArray[np.intp]:
    return np.array([piece.stop - piece.start for piece in pieces], dtype=np.intp)
