"""Damping beyond the learned rates, where the sum of kernels would fall back to zero: a lie about drag."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from incsvr.numerics import Array


@dataclass(frozen=True, slots=True)
class Continuation:
    """Linear and quadratic drag D(r) = l r + q r|r| with l, q ≥ 0, fitted to the learned curve and tied to its ends.

    Outward from an end e of the learned range the curve goes on as f(e) + D(r) − D(e): continuous, growing, and
    dissipative wherever f(e) is. Where rest lies outside the range it returns to zero at rest as f(e) D(r)/D(e), and
    beyond rest, on the side that nobody has seen, it is D(r).
    """

    linear: float  # l [N m s/rad] and q [N m s²/rad²]
    quadratic: float
    covariance: tuple[float, float, float]  # of both: the variance of l, their covariance, the variance of q

    @staticmethod
    def fit(rate: Array, damping: Array, precision: Array) -> Continuation:
        """l and q ≥ 0 by weighted least squares on (n,) points of the curve.

        Args:
            rate, damping: of the points [rad/s], [N m].
            precision: (n,) 1/variance of each [1/(N m)²].

        A wide prior (either term alone may reach the largest moment) decides what the points leave open: at one rate
        alone the two terms cannot be told apart.
        """
        size = np.abs(rate)
        fastest, largest = float(size.max()) or 1.0, float(np.abs(damping).max()) or 1.0
        weight = precision * rate
        square = weight * rate
        a = float(np.add.reduce(square)) + (fastest / largest) ** 2
        b, c = float(square.dot(size)), float(square.dot(size * size)) + (fastest**2 / largest) ** 2
        by_linear, by_quadratic = float(weight.dot(damping)), float((weight * size).dot(damping))
        determinant = max(a * c - b * b, 1e-14 * a * c)  # at one rate alone rounding is all of it
        linear = (c * by_linear - b * by_quadratic) / determinant
        quadratic = (a * by_quadratic - b * by_linear) / determinant
        if min(linear, quadratic) < 0.0:  # one of the two alone
            linear, quadratic = max(by_linear / a, 0.0), max(by_quadratic / c, 0.0)
            if linear * by_linear >= quadratic * by_quadratic:
                quadratic = 0.0
            else:
                linear = 0.0
        return Continuation(linear, quadratic, (c / determinant, -b / determinant, a / determinant))

    def predict(self, rate: Array, end: Array, at_end: Array, doubt: Array) -> tuple[Array, Array, Array]:
        """Damping, its derivative and its standard deviation without the noise of a sample, each (n,), at (n,) rates
        outside.

        Args:
            end: (n,) the end of the learned range that is nearest to each [rad/s].
            at_end, doubt: (n,) f there and its standard deviation [N m].
        """
        size, size_of_end = np.abs(rate), np.abs(end)
        drag, drag_at_end = (v * (self.linear + self.quadratic * s) for v, s in ((rate, size), (end, size_of_end)))
        slope = self.linear + 2.0 * self.quadratic * size
        share = np.divide(at_end, drag_at_end, out=np.zeros(rate.size), where=drag_at_end != 0.0)
        past_rest, inward = rate * end < 0.0, size < size_of_end
        value = np.where(past_rest, drag, np.where(inward, share * drag, at_end + drag - drag_at_end))
        derivative = np.where(inward & ~past_rest, share * slope, slope)
        a, b, c = self.covariance
        slower, faster = rate - end, rate * size - end * size_of_end
        variance = slower * (a * slower + 2.0 * b * faster) + c * faster * faster
        return value, derivative, np.sqrt(doubt * doubt + np.maximum(variance, 0.0))
