"""Answers from a model: damping, how sure it is, and whether it was learned there; from a table, in microseconds.

The table is a cubic Hermite spline of the curve. With nodes h apart it is off by less than h⁴ max|f⁗|/384, and since
|f⁗| ≤ ‖f‖ √1680 γ², NODE_DISTANCE_LENGTHS keeps that below 1e-5 N m for a curve of 1,000 N m.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import ceil, sqrt

import numpy as np
from numpy.typing import NDArray

from incsvr.errors import BadInput
from incsvr.learning.continuation import Continuation
from incsvr.learning.kernel import rbf
from incsvr.learning.support_set import SupportSet
from incsvr.numerics import Array, lapack

NODE_DISTANCE_LENGTHS = 0.015
"""Distance of two nodes, in kernel lengths 1/√γ."""
MAX_NODES = 4096
"""Nodes of a table at most."""
MIN_RANGE_RAD_S = 1e-9
"""Width of a learned range below which it is one rate [rad/s]."""
MAX_GAP_LENGTHS = 0.5
"""Distance from the nearest vector beyond which a rate between vectors is not learned either, in kernel lengths."""


@dataclass(frozen=True, slots=True)
class Prediction:
    """Damping at some rates.

    Attributes:
        damping: (n,) f(r) [N m].
        sigma: (n,) standard deviation of one fresh sample about it [N m]: noise and doubt together.
        extrapolated: (n,) whether the rate lies where nothing was learned.
        noise: (n,) the samples' own deviation there [N m].
        derivative: (n,) ∂f/∂r, with respect to the axis's own velocity [N m s/rad].
    """

    damping: Array
    sigma: Array
    extrapolated: NDArray[np.bool_]
    noise: Array
    derivative: Array

    @property
    def doubt(self) -> Array:
        """(n,) standard deviation of the curve itself [N m], which grows where the data are thin."""
        return np.asarray(np.sqrt(np.maximum(self.sigma**2 - self.noise**2, 0.0)))


@dataclass(frozen=True, eq=False)
class Table:
    """A model made ready for questions.

    Attributes:
        support: the vectors.
        low, high: the learned range [rad/s].
        scale, cells: nodes stand at low, low + 1/scale, …, low + cells/scale.
        rows: (8, cells + 1): the cubic of each cell in u ∈ [0, 1), then sigma and its increase, then the noise and its
            increase; the last node is a cell of its own.
        thin: (cells + 1,) whether a cell is far from every vector; None where none is.
        beyond: the curve outside.
    """

    support: SupportSet
    low: float
    high: float
    scale: float
    cells: int
    rows: Array
    thin: NDArray[np.bool_] | None
    beyond: Continuation

    @staticmethod
    def of(support: SupportSet) -> Table:
        x = support.rate
        low, high = float(x.min()), float(x.max())
        span = high - low
        cells = min(max(ceil(span * sqrt(support.gamma) / NODE_DISTANCE_LENGTHS), 1), MAX_NODES)
        h = span / cells if span > MIN_RANGE_RAD_S else 1.0
        nodes = np.linspace(low, low + h * cells, cells + 1)
        kernel = rbf(nodes, x, support.gamma)
        f = kernel @ support.weight
        slope = (-2.0 * support.gamma * h) * (nodes * f - kernel @ (support.weight * x))
        following = np.append(slope[1:], 0.0)
        doubt, noise = _doubt(support, nodes, kernel), support.sample_noise(nodes)
        sigma = np.hypot(noise, doubt)
        at_nodes = np.array((f, sigma, noise))
        rise, increase, louder = np.diff(at_nodes, append=at_nodes[:, -1:])
        rows = np.array(
            (
                f,
                slope,
                3.0 * rise - 2.0 * slope - following,
                slope + following - 2.0 * rise,
                sigma,
                increase,
                noise,
                louder,
            )
        )
        ordered = np.sort(x)
        edges = 0.5 * (ordered[1:] + ordered[:-1])
        nearest = ordered[np.searchsorted(edges, nodes)]
        thin = np.abs(nodes - nearest) > MAX_GAP_LENGTHS / sqrt(support.gamma)
        beyond = Continuation.fit(
            x,
            support.curve,
            support.worth * support.count / np.maximum(support.noise, 1e-9) ** 2,
            ends=(low, high),
            at_ends=(float(f[0]), float(f[-1])),
            doubt=(float(doubt[0]), float(doubt[-1])),
        )
        return Table(support, low, high, 1.0 / h, cells, rows, thin if thin.any() else None, beyond)

    def predict(self, rate: Array) -> Prediction:
        """The prediction at (n,) rates [rad/s]."""
        if rate.size == 1 and self.low <= (one := float(rate[0])) <= self.high:
            return Prediction(*(np.array((value,)) for value in self.one(one)))
        inside = np.minimum(np.maximum(rate, self.low), self.high)
        outside = inside != rate
        beyond = bool(outside.any())
        if beyond and not np.isfinite(rate).all():
            raise BadInput("a rate is not finite; give numbers in rad/s")
        place = np.minimum((inside - self.low) * self.scale, self.cells)
        cell = place.astype(np.intp)
        u = place - cell
        f, slope, bend, twist, sigma, increase, noise, louder = self.rows.take(cell, axis=1)
        damping = ((twist * u + bend) * u + slope) * u + f
        derivative = ((3.0 * twist * u + 2.0 * bend) * u + slope) * self.scale
        sigma, noise = increase * u + sigma, louder * u + noise
        if beyond:
            damping[outside], doubt = self.beyond.predict(rate[outside])
            derivative[outside] = self.beyond.derivative(rate[outside])
            noise[outside] = self.support.sample_noise(rate[outside])
            sigma[outside] = np.hypot(noise[outside], doubt)
        if self.thin is not None:
            outside |= self.thin[cell]
        return Prediction(damping, sigma, outside, noise, derivative)

    @cached_property
    def one(self) -> Callable[[float], tuple[float, float, bool, float, float]]:
        """Damping, sigma, extrapolated, noise and derivative at one learned rate [rad/s], as plain numbers.

        Questions for one rate are frequent, and the calls of NumPy cost ten times its arithmetic.
        """
        rows, thin = self.rows.T.tolist(), None if self.thin is None else self.thin.tolist()
        low, scale, last = self.low, self.scale, float(self.cells)

        def at(rate: float) -> tuple[float, float, bool, float, float]:
            place = min((rate - low) * scale, last)
            cell = int(place)
            u = place - cell
            f, slope, bend, twist, sigma, increase, noise, louder = rows[cell]
            damping = ((twist * u + bend) * u + slope) * u + f
            derivative = ((3.0 * twist * u + 2.0 * bend) * u + slope) * scale
            return damping, increase * u + sigma, thin is not None and thin[cell], louder * u + noise, derivative

        return at


def _doubt(support: SupportSet, nodes: Array, kernel: Array) -> Array:
    """Standard deviation of the curve at the nodes [N m].

    That of a Gaussian process with the model's kernel, the curve's largest moment as its scale, and as much noise in
    each vector as its samples leave; and what the support set adds to it.

    Args:
        nodes: (k,) rates [rad/s].
        kernel: (k, m) κ between them and the vectors.
    """
    scale = support.largest_damping
    ratio = (np.maximum(support.noise, 1e-6 * scale) / scale) ** 2
    gram = support.gram + np.diag(ratio / (support.worth * support.count))
    solved = lapack.dpotrs(lapack.cholesky(gram), kernel.T)[0]
    explained = (kernel.T * solved).sum(axis=0)
    return support.doubt(scale**2 * np.maximum(1.0 - explained, 0.0), nodes)
