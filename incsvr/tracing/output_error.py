"""The declared inertia held against the motion by output error, where it may be wrong by any factor.

An equation error gives an inertia that is too small wherever noise, or a thrust that is not quite the command's, sits
in what is differentiated. The free run I ṙ = τ − b − N_r r − N_rr r|r| does not differentiate. It is brought as close
as possible to the measured yaw rate, in stretches that begin at a measured one, over I, the damping and a constant
moment (L. Ljung, System Identification, 1999, ch. 4). Only a factor is judged so: what is nearer than that, a lag or a
dead band moves as well, and the search tells it beside them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from incsvr.effects import Signals

Array = NDArray[np.float64]

FACTOR = 2.0
"""Between the declared inertia and the nearer end of the identified one's 95 % interval, from which it is said that the
declaration is wrong: hidden lags, dead bands and thrust that fades make at most 1.5 of it."""

STRETCH = 12.0
"""Time scales of the motion in a stretch: long beside what its first measured rate is remembered."""

STEPS = 14.0
"""Steps in a time scale: the inertia is told by what is slower."""

TURNS = (15, 8)
"""Evaluations at most, from the start and with spikes weighed down."""

BLOCKS = 20
"""Of time, between which the scores scatter: for a standard error that holds where residuals have a memory."""

NUDGE = 1e-5
"""Step of the numerical derivatives, in the parameters' units."""

RUNAWAY = 4.0
"""Of the fastest measured rate: a free run is held there."""


@dataclass(frozen=True, slots=True)
class Identified:
    """An inertia from free runs.

    Attributes:
        inertia: [kg m²].
        low, high: its 95 % interval.
        rmse: of these free runs [rad/s].
        declared_rmse: of those with the declared inertia and a damping of their own [rad/s].
    """

    inertia: float
    low: float
    high: float
    rmse: float
    declared_rmse: float

    def contradicts(self, declared: float) -> bool:
        """Whether the declared inertia is wrong by a factor."""
        far = self.low > FACTOR * declared or self.high < declared / FACTOR
        return far and self.rmse < self.declared_rmse


def identified(s: Signals) -> Identified | None:
    """The inertia that these recordings show, of a torque that holds through each cell; None where they show none."""
    runs = _Stretches.of(s)
    fastest, largest = float(np.max(np.abs(s.rate))), float(np.max(np.abs(s.torque)))
    if runs is None or fastest <= 0.0 or largest <= 0.0:
        return None
    # of a damping in units of the largest torque at the fastest rate, and an inertia by its logarithm
    unit = np.array([1.0, largest / fastest, largest / fastest**2, largest])

    def errors(unknown: Array) -> Array:
        """(m, n) of m sets of parameters."""
        return runs.errors(np.exp(unknown[:, 0]), unknown[:, 1:] * unit[1:], RUNAWAY * fastest) / fastest

    start = np.array([np.log(s.inertia), 0.3, 0.3, 0.0])
    near, damping_fit, _ = _fit(errors, start, slice(1, 4))
    starts = [near]
    regressed = _by_regression(s)
    if not 1.0 / FACTOR < regressed / s.inertia < FACTOR:  # far from the truth free runs lose their way
        starts.append(np.array([np.log(max(regressed, 1e-3 * s.inertia)), *start[1:]]))
    fits = [_fit(errors, each, slice(0, 4)) for each in starts]
    best, left, slopes = min(fits, key=lambda found: float(found[1] @ found[1]))
    relative = _relative_error(slopes, left)
    if not np.isfinite(relative):
        return None
    inertia = float(np.exp(best[0]))
    rmse, declared = (fastest * float(np.sqrt(np.mean(each**2))) for each in (left, damping_fit))
    half = 1.96 * min(relative, 100.0)  # beyond, it is any inertia at all, and the exponential overflows
    return Identified(inertia, inertia * float(np.exp(-half)), inertia * float(np.exp(half)), rmse, declared)


@dataclass(frozen=True, slots=True)
class _Stretches:
    """Stretches of the recordings side by side, the shorter ones filled up with zeros.

    Attributes:
        step: [s].
        torque: (cells, stretches) [N m].
        rate: (cells + 1, stretches) measured [rad/s].
        known: (cells + 1, stretches) where there is a measured one to be met.
    """

    step: float
    torque: Array
    rate: Array
    known: NDArray[np.bool_]

    @staticmethod
    def of(s: Signals) -> _Stretches | None:
        many = max(int(s.scale / STEPS / s.step), 1)
        length = max(round(STRETCH * s.scale / s.step / many), 20)
        pieces = []
        for a, b in pairwise(s.start):
            torque = s.torque[a : b - (b - a) % many].reshape(-1, many).mean(axis=1)
            rate = s.rate[a : b - (b - a) % many : many]
            edges = np.linspace(0, rate.size, max(round(rate.size / length), 1) + 1).astype(int)
            pieces += [(torque[p : q - 1], rate[p:q]) for p, q in pairwise(edges) if q - p > 10]
        if not pieces:
            return None
        cells = max(torque.size for torque, _ in pieces)
        moments = np.zeros((cells, len(pieces)))
        rates, known = np.zeros((cells + 1, len(pieces))), np.zeros((cells + 1, len(pieces)), dtype=bool)
        for k, (torque, rate) in enumerate(pieces):
            moments[: torque.size, k], rates[: rate.size, k], known[1 : rate.size, k] = torque, rate, True
        return _Stretches(many * s.step, moments, rates, known)

    def errors(self, inertia: Array, damping: Array, most: float) -> Array:
        """(m, n) simulated minus measured rate: exponential Euler, exact where the drag is linear."""
        gain = self.step / inertia[:, None]
        linear, quadratic, constant = (column[:, None] for column in damping.T)
        rate = np.broadcast_to(self.rate[0], (inertia.size, self.rate.shape[1])).copy()
        out = np.empty((self.torque.shape[0], *rate.shape))
        for k, moment in enumerate(self.torque):
            size = np.abs(rate)
            slope = np.clip(gain * (linear + 2.0 * quadratic * size), -0.5, 50.0)
            slope = np.where(np.abs(slope) < 1e-6, 1e-6, slope)
            push = gain * (moment - constant - (linear + quadratic * size) * rate)
            rate = np.clip(rate - np.expm1(-slope) / slope * push, -most, most)
            out[k] = rate
        return np.asarray((out - self.rate[1:, None, :]).transpose(1, 2, 0)[:, self.known[1:].T])


def _fit(errors: Callable[[Array], Array], start: Array, free: slice) -> tuple[Array, Array, Array]:
    """The best parameters, their errors (n,) and the slopes of these (n, p); the parameters that are not free stay."""

    def errors_of_all(found: Array) -> Array:
        unknown = np.tile(start, (len(found), 1))
        unknown[:, free] = found
        return errors(unknown)

    def slopes(found: Array) -> Array:
        moved = errors_of_all(found + np.concatenate([np.zeros((1, found.size)), NUDGE * np.eye(found.size)]))
        return np.asarray((moved[1:] - moved[0]).T / NUDGE)

    def left(found: Array) -> Array:
        return np.asarray(errors_of_all(found[None])[0])

    rough = least_squares(left, start[free], slopes, method="trf", max_nfev=TURNS[0])
    soft = 3.0 * max(1e-9, 1.4826 * float(np.median(np.abs(rough.fun))))
    fine = least_squares(left, rough.x, slopes, loss="soft_l1", f_scale=soft, max_nfev=TURNS[1])
    unknown = start.copy()
    unknown[free] = fine.x
    return unknown, left(fine.x), slopes(fine.x)


def _by_regression(s: Signals) -> float:
    """I [kg m²] of mean τ = I Δr/T + N_r r + N_rr r|r| + b over blocks of half a time scale: biased, but near."""
    size = max(round(0.5 * s.scale / s.step), 1)
    rows, targets = [], []
    for a, b in pairwise(s.start):
        for p in range(a, b - size - 1, size):
            rate = s.rate[p : p + size]
            rise = (s.rate[p + size] - s.rate[p]) / (size * s.step)
            rows.append((rise, rate.mean(), (rate * np.abs(rate)).mean(), 1.0))
            targets.append(s.torque[p : p + size].mean())
    return float(np.linalg.lstsq(np.array(rows), np.array(targets))[0][0]) if len(rows) > 8 else s.inertia


def _relative_error(slopes: Array, left: Array) -> float:
    """Standard error of ln I by the sandwich formula, scores summed over blocks of time."""
    information = slopes.T @ slopes
    if np.linalg.cond(information) > 1e12:
        return np.inf
    starts = np.linspace(0, left.size, BLOCKS, endpoint=False).astype(int)
    sums = np.add.reduceat(slopes * left[:, None], starts, axis=0)
    bread = np.linalg.inv(information)
    covariance = bread @ (sums.T @ sums) @ bread * (BLOCKS / (BLOCKS - 1.0))
    return float(np.sqrt(covariance[0, 0]))
