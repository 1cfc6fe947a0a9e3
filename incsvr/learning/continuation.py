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

    Attributes:
        coefficients: l [N m s/rad] and q [N m s²/rad²].
        covariance: (2, 2) of them.
        ends: the learned range [rad/s].
        damping: f at its ends [N m].
        doubt: standard deviation of f there [N m].
    """

    coefficients: Array
    covariance: Array
    ends: tuple[float, float]
    damping: tuple[float, float]
    doubt: tuple[float, float]

    @staticmethod
    def fit(
        rate: Array,
        damping: Array,
        precision: Array,
        *,
        ends: tuple[float, float],
        at_ends: tuple[float, float],
        doubt: tuple[float, float],
    ) -> Continuation:
        """l and q ≥ 0 by weighted least squares on (n,) points of the curve.

        Args:
            rate, damping: of the points [rad/s], [N m].
            precision: (n,) 1/variance of each [1/(N m)²].
            ends, at_ends, doubt: the learned range, and the curve and its standard deviation there.

        A wide prior (either term alone may reach the largest moment) decides what the points leave open: at one rate
        alone the two terms cannot be told apart.
        """
        drag = _terms(rate)
        fastest, largest = float(np.abs(rate).max()) or 1.0, float(np.abs(damping).max()) or 1.0
        prior = np.diag([fastest**2, fastest**4]) / largest**2
        information = (drag.T * precision) @ drag + prior
        pull = drag.T @ (precision * damping)
        covariance = np.asarray(np.linalg.inv(information), dtype=np.float64)
        best = covariance @ pull
        if best.min() < 0.0:  # one of the two alone
            alone = np.maximum(pull / np.diag(information), 0.0)
            gain = alone * pull
            best = np.where(np.arange(2) == int(gain.argmax()), alone, 0.0)
        return Continuation(best, covariance, ends, at_ends, doubt)

    def predict(self, rate: Array) -> tuple[Array, Array]:
        """Damping and its standard deviation without the noise of a sample, both (n,) [N m], at rates outside (n,)."""
        upper = rate > self.ends[1]
        end = np.where(upper, self.ends[1], self.ends[0])
        damping = np.where(upper, self.damping[1], self.damping[0])
        doubt = np.where(upper, self.doubt[1], self.doubt[0])
        linear, quadratic = self.coefficients.tolist()
        (a, b), (_, c) = self.covariance.tolist()
        slower, faster = rate - end, rate * np.abs(rate) - end * np.abs(end)
        far = linear * rate + quadratic * rate * np.abs(rate)
        at_end = linear * end + quadratic * end * np.abs(end)
        onward = damping + linear * slower + quadratic * faster
        share = np.divide(far, at_end, out=np.zeros(rate.size), where=at_end != 0.0)
        inward = np.abs(rate) < np.abs(end)
        value = np.where(rate * end < 0.0, far, np.where(inward, damping * share, onward))
        variance = a * slower * slower + 2.0 * b * slower * faster + c * faster * faster
        return value, np.sqrt(doubt * doubt + np.maximum(variance, 0.0))

    def derivative(self, rate: Array) -> Array:
        """(n,) derivative of the damping at rates outside (n,) [N m s/rad]."""
        upper = rate > self.ends[1]
        end = np.where(upper, self.ends[1], self.ends[0])
        damping = np.where(upper, self.damping[1], self.damping[0])
        linear, quadratic = self.coefficients.tolist()
        slope = linear + 2.0 * quadratic * np.abs(rate)
        at_end = linear * end + quadratic * end * np.abs(end)
        share = np.divide(damping, at_end, out=np.zeros(rate.size), where=at_end != 0.0)
        return np.asarray(np.where((rate * end >= 0.0) & (np.abs(rate) < np.abs(end)), share * slope, slope))


def _terms(rate: Array) -> Array:
    """(n, 2) r and r|r|."""
    return np.stack((rate, rate * np.abs(rate)), axis=1)
