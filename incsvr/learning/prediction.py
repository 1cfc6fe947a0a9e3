"""Answers from a model over one velocity: damping, how sure it is, and whether it was learned there."""

from __future__ import annotations

from bisect import bisect
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import exp, sqrt

import numpy as np
from numpy.typing import NDArray

from incsvr.errors import BadInput
from incsvr.learning.continuation import Continuation
from incsvr.learning.doubt import NOISE_SHARE, Doubt, variance_of
from incsvr.learning.kernel import Pivots, Series, rbf
from incsvr.learning.support import Support
from incsvr.numerics import Array, lapack

MAX_GAP_LENGTHS = 0.5
"""Distance from the nearest vector beyond which a rate between vectors is not learned either, in lengths 1/√γ."""


@dataclass(frozen=True, slots=True)
class Prediction:
    """Damping at some rates."""

    damping: Array  # (n,) f(r) [N m]
    sigma: Array  # (n,) standard deviation of one fresh sample about it [N m]: noise and doubt together
    extrapolated: NDArray[np.bool_]  # (n,) whether the rate lies where nothing was learned
    noise: Array  # (n,) the samples' own deviation there [N m]
    derivative: Array  # (n,) ∂f/∂r, with respect to the axis's own velocity [N m s/rad]

    @property
    def doubt(self) -> Array:
        """(n,) standard deviation of the curve itself [N m], which grows where the data are thin."""
        return np.asarray(np.sqrt(np.maximum(self.sigma**2 - self.noise**2, 0.0)))


@dataclass(frozen=True, eq=False)
class Curve:
    """A model over one velocity made ready for questions: products with the kernel's columns φ."""

    model: Support  # the model
    low: float  # the learned range [rad/s]
    high: float
    columns: Series | Pivots  # of the kernel
    phi: Array  # (rank, m) φ at the vectors
    scale: float  # the largest damping of the vectors [N m]; never zero
    variance: Array  # (m,) of the vectors [N² m²]
    doubt: Doubt  # of the curve

    @staticmethod
    def of(model: Support) -> Curve:
        x, count = model.support_rate, model.count
        low, high = float(x.min()), float(x.max())
        columns: Series | Pivots | None = Series.over(low, high, model.gamma)
        if columns is not None:
            phi = columns.at(x)
        else:
            columns, phi = Pivots.of(x, model.gamma, vanishing=False)
        scale = max(float(np.abs(model.support_damping).max()), 1e-9)
        variance = variance_of(model.sigma * model.spread.at(x), count, model.correlation, scale)
        learned = float(count @ x**2) / float(count.sum())
        doubt = Doubt.of(scale * phi, variance, learned, model.sigma, model.spread, model.water, model.widening)
        return Curve(model, low, high, columns, phi, scale, variance, doubt)

    @cached_property
    def weights(self) -> Array:
        """(2, rank) w = Φθ, f = wᵀφ, and the weights of the slope, f' = w'ᵀφ − 2γ(x − centre) f, of a series."""
        w = np.zeros((2, self.phi.shape[0]))
        w[0] = self.phi.dot(self.model.weight)
        w[1, :-1] = np.sqrt(2.0 * self.model.gamma * np.arange(1.0, w.shape[1])) * w[0, 1:]
        return w

    @property
    def at_vectors(self) -> Array:
        """(m,) f at the vectors [N m]."""
        return np.asarray(self.weights[0].dot(self.phi))

    def predict(self, rate: Array) -> Prediction:
        """The prediction at (n,) rates [rad/s]."""
        if rate.size == 1 and self.low <= (one := float(rate[0])) <= self.high:
            return Prediction(*(np.array((value,)) for value in self.one(one)))
        inside = np.minimum(np.maximum(rate, self.low), self.high)
        outside = inside != rate
        beyond = bool(outside.any())
        if beyond and not np.isfinite(rate).all():
            raise BadInput("a rate is not finite; give numbers in rad/s")
        damping, derivative, doubt = self._within(inside)
        if beyond:
            ends = (values[outside] for values in (rate, inside, damping, doubt))
            damping[outside], derivative[outside], doubt[outside] = self._beyond.predict(*ends)
        if self._gaps:
            ordered, edges, reach = self._gaps
            outside |= np.abs(inside - ordered[edges.searchsorted(inside)]) > reach
        noise = self.doubt.noise(rate)
        return Prediction(damping, np.hypot(noise, doubt), outside, noise, derivative)

    def _within(self, x: Array) -> tuple[Array, Array, Array]:
        """(n,) damping, derivative and doubt at (n,) learned rates."""
        model, phi = self.model, self.columns.at(x)
        if isinstance(self.columns, Series):
            f, slope = self.weights.dot(phi)
            derivative = slope - 2.0 * model.gamma * (x - self.columns.centre) * f
            return f, derivative, self.doubt.at(x, self.scale * phi)
        kernel = rbf(x, model.support_rate, model.gamma)
        f = kernel @ model.weight
        derivative = 2.0 * model.gamma * (kernel @ (model.weight * model.support_rate) - x * f)
        left = self.scale**2 * np.maximum(1.0 - np.add.reduce(phi * phi, axis=0), 0.0)
        return f, derivative, self.doubt.at(x, self.scale * phi, left)

    @cached_property
    def _gaps(self) -> tuple[Array, Array, float] | None:
        """The vectors' rates in order, the middles between them, and how far from them is learned [rad/s]; None where
        every rate within the range is near one."""
        ordered, reach = np.sort(self.model.support_rate), MAX_GAP_LENGTHS / sqrt(self.model.gamma)
        edges = 0.5 * (ordered[1:] + ordered[:-1])
        return (ordered, edges, reach) if (np.diff(ordered) > 2.0 * reach).any() else None

    @cached_property
    def _beyond(self) -> Continuation:
        return Continuation.fit(self.model.support_rate, self.at_vectors, 1.0 / self.variance)

    @cached_property
    def one(self) -> Callable[[float], tuple[float, float, bool, float, float]]:
        """Damping, sigma, extrapolated, noise and derivative at one learned rate [rad/s], as plain numbers.

        Questions for one rate are frequent, and the calls of NumPy cost ten times its arithmetic: on a series all three
        sums are polynomials of u = x − centre times exp(−γu²), or its square.
        """
        columns, doubt = self.columns, self.doubt
        if not isinstance(columns, Series):

            def by_columns(rate: float) -> tuple[float, float, bool, float, float]:
                found = self.predict(np.array((rate, rate)))
                return (
                    *(float(found.damping[0]), float(found.sigma[0]), bool(found.extrapolated[0])),
                    *(float(found.noise[0]), float(found.derivative[0])),
                )

            return by_columns
        gamma, centre, powers = columns.gamma, columns.centre, np.cumprod(np.append(1.0, columns.factors))
        rank = powers.size
        inverse = lapack.dpotrs(doubt.factor, np.eye(rank))[0] * np.multiply.outer(powers, powers) * self.scale**2
        degrees = np.add.outer(np.arange(rank), np.arange(rank)).ravel()
        variances = np.bincount(degrees, inverse.ravel())[::-1].tolist()
        curve = list(zip(*(self.weights * powers)[:, ::-1].tolist(), strict=True))
        constant, slope_by_water, widening = doubt.systematic**2, doubt.slope, doubt.widening
        level, (knots, fastest) = NOISE_SHARE * doubt.sigma, (doubt.spread.variance, doubt.spread.fastest)
        last, gaps = len(knots) - 1, self._gaps
        ordered, edges, reach = ([], [], 0.0) if gaps is None else (gaps[0].tolist(), gaps[1].tolist(), gaps[2])

        def at(rate: float) -> tuple[float, float, bool, float, float]:
            u = rate - centre
            kernel = exp(-gamma * u * u)
            f = slope = variance = 0.0
            for of_f, of_slope in curve:
                f, slope = f * u + of_f, slope * u + of_slope
            for each in variances:
                variance = variance * u + each
            f, slope, variance = f * kernel, slope * kernel, variance * kernel * kernel
            far = bool(ordered) and abs(rate - ordered[bisect(edges, rate)]) > reach
            place = min(abs(rate) / fastest, 1.0) * last
            knot = min(int(place), last - 1)
            noise = level * sqrt(knots[knot] + (place - knot) * (knots[knot + 1] - knots[knot]))
            own = widening * sqrt(max(variance, 0.0) + constant + (slope_by_water * rate) ** 2)
            return f, sqrt(noise * noise + own * own), far, noise, slope - 2.0 * gamma * u * f

        return at
