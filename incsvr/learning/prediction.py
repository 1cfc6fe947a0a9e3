"""The answer of a model at some rates, and how a curve goes on beyond those that it has learned."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array


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


@dataclass(frozen=True, slots=True)
class Continuation:
    """Damping beyond the learned rates of one velocity, where the sum of kernels would fall to zero: a lie about drag.

    Linear and quadratic drag D(r) = l r + q r|r| with l, q ≥ 0, fitted to the learned curve and tied to its ends.
    Outward from an end e of the learned range the curve goes on as f(e) + D(r) − D(e): continuous, growing, and
    dissipative wherever f(e) is. Where rest lies outside the range it returns to zero at rest as f(e) D(r)/D(e), and
    beyond rest, on the side that nobody has seen, it is D(r).
    """

    drag: Array  # (2,) l [N m s/rad] and q [N m s²/rad²]
    covariance: Array  # (2, 2) of both

    @staticmethod
    def fit(rate: Array, damping: Array, precision: Array) -> Continuation:
        """l and q ≥ 0 by weighted least squares on (n,) points of the curve, with `precision` 1/variance [1/(N m)²].

        A wide prior (either term alone may reach the largest moment) decides what the points leave open: at one rate
        alone the two terms cannot be told apart.
        """
        fastest, largest = float(np.abs(rate).max()) or 1.0, float(np.abs(damping).max()) or 1.0
        terms = _drag(rate)
        weighted = terms * precision
        (a, b), (_, c) = (weighted @ terms.T).tolist()
        a, c = a + (fastest / largest) ** 2, c + (fastest**2 / largest) ** 2
        covariance = np.array(((c, -b), (-b, a))) / max(a * c - b * b, 1e-14 * a * c)
        pull = weighted @ damping
        drag = covariance @ pull
        if drag.min() < 0.0:  # one of the two alone
            alone = np.maximum(pull / np.array((a, c)), 0.0)
            drag = np.where(np.arange(2) == np.argmax(alone * pull), alone, 0.0)
        return Continuation(drag, covariance)

    def predict(self, rate: Array, end: Array, at_end: Array, doubt: Array) -> tuple[Array, Array, Array]:
        """Damping, its derivative and the curve's standard deviation, each (n,), at (n,) rates outside.

        Args:
            end: (n,) the end of the learned range that is nearest to each [rad/s].
            at_end, doubt: (n,) f there and its standard deviation [N m].
        """
        change = _drag(rate) - _drag(end)
        drag, drag_at_end = self.drag @ _drag(rate), self.drag @ _drag(end)
        slope = self.drag[0] + 2.0 * self.drag[1] * np.abs(rate)
        share = np.divide(at_end, drag_at_end, out=np.zeros(rate.size), where=drag_at_end != 0.0)
        past_rest, inward = rate * end < 0.0, np.abs(rate) < np.abs(end)
        value = np.where(past_rest, drag, np.where(inward, share * drag, at_end + drag - drag_at_end))
        derivative = np.where(inward & ~past_rest, share * slope, slope)
        variance = np.add.reduce(change * (self.covariance @ change), axis=0)
        return value, derivative, np.sqrt(doubt**2 + np.maximum(variance, 0.0))


def _drag(rate: Array) -> Array:
    """(2, n) linear and quadratic drag of (n,) rates."""
    return np.stack((rate, rate * np.abs(rate)))
