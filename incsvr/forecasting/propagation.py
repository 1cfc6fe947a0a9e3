"""Free runs side by side with what makes them uncertain: the water, and the doubt of the curve itself.

    I ṙ = τ − d(r) + w,  ψ̇ = r,  w a first-order Gauss–Markov process

The mean follows an exponential (Rosenbrock–Euler) step, which is stable for any step and exact where d is a line. The
covariance of (r, ψ, w) follows the same linearisation. The doubt of the curve is no noise: it is off to one side for
long, so that it is carried as a sensitivity and its square added.

Source: M. Hochbruck, A. Ostermann, Exponential integrators, Acta Numerica 19, 2010, eq. (1.6); A. Gelb (ed.), Applied
Optimal Estimation, 1974, ch. 3.8 (shaping filters).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from incsvr.learning.model import Model
from incsvr.numerics import Array

TABLE_NODES = 2001
"""Rates at which a curve is tabulated."""
TABLE_REACH = 2.5
"""Ends of the table, in fastest rates: a free run that is beyond is no forecast of anything."""
MIN_CORRELATION = 0.05
"""Correlation of the noise of two samples, at least: less cannot be told from none, and would be a time of nearly
nothing."""


@dataclass(frozen=True, slots=True)
class Curve:
    """A model's damping in even steps of the rate, and what noise its samples have.

    Attributes:
        low, step: the rates are low, low + step, … [rad/s].
        damping, slope, sigma: (TABLE_NODES,) d(r) [N m], d′(r) [N m s/rad], one standard deviation of the curve [N m].
        inertia: I [kg m²].
        disturbance: one standard deviation of w [N m].
        lasts: its correlation time [s].
    """

    low: float
    step: float
    damping: Array
    slope: Array
    sigma: Array
    inertia: float
    disturbance: float
    lasts: float

    @staticmethod
    def of(model: Model, inertia: float, fastest: float, period: float) -> Curve:
        """A trained model's, out to TABLE_REACH times the fastest rate [rad/s]; `period` is between two samples [s]."""
        rates = np.linspace(-TABLE_REACH * fastest, TABLE_REACH * fastest, TABLE_NODES)
        said = model.predict(rates)
        step = float(rates[1] - rates[0])
        # A free run must not gain energy: where a curve drives, by its own doubt, it is taken for a flat one.
        slope = np.maximum(np.gradient(said.damping, step), 0.0)
        lasts = -period / math.log(min(max(model.correlation, MIN_CORRELATION), 0.999))
        return Curve(
            float(rates[0]), step, said.damping, slope, said.curve_sigma, inertia, float(model.sigma), float(lasts)
        )

    def at(self, rate: Array) -> tuple[Array, Array, Array]:
        """Damping, slope and doubt at (n,) rates, those of the ends beyond them."""
        place = np.clip((rate - self.low) / self.step, 0.0, TABLE_NODES - 1.001)
        cell = place.astype(np.intp)
        part = place - cell
        return (
            self.damping[cell] + part * (self.damping[cell + 1] - self.damping[cell]),
            self.slope[cell],
            self.sigma[cell],
        )


@dataclass(frozen=True, slots=True)
class Runs:
    """Free runs at the ends of their steps, the start first.

    Attributes:
        rate, heading: (steps + 1, n) [rad/s], [rad] turned since the start.
        rate_sigma, heading_sigma: (steps + 1, n) one standard deviation.
    """

    rate: Array
    heading: Array
    rate_sigma: Array
    heading_sigma: Array


def propagate(curve: Curve, rate: Array, rate_sigma: float, torque: Array, step: float) -> Runs:
    """n free runs of the same length.

    Args:
        rate: (n,) where they start [rad/s].
        rate_sigma: how well that is known [rad/s].
        torque: (steps + 1, n) at the ends of the steps, linear between [N m].
        step: [s].
    """
    steps, count = torque.shape[0] - 1, rate.size
    out = np.empty((4, steps + 1, count))
    r, psi = rate.astype(np.float64), np.zeros(count)
    # Covariance of (r, ψ, w), and the sensitivity of (r, ψ) to one deviation of the curve.
    rr, rp, pp = np.full(count, rate_sigma**2), np.zeros(count), np.zeros(count)
    rw, pw, ww = np.zeros(count), np.zeros(count), curve.disturbance**2
    off_r, off_psi = np.zeros(count), np.zeros(count)
    stays = math.exp(-step / curve.lasts)
    fresh = ww * (1.0 - stays**2)
    for k in range(steps + 1):
        out[0, k], out[1, k] = r, psi
        out[2, k], out[3, k] = np.sqrt(rr + off_r**2), np.sqrt(np.maximum(pp, 0.0) + off_psi**2)
        if k == steps:
            break
        damping, slope, sigma = curve.at(r)
        decay = np.exp(-slope * step / curve.inertia)
        gain = np.where(slope > 0.0, (1.0 - decay) / np.maximum(slope, 1e-300), step / curve.inertia)
        before = r
        r = r + gain * (0.5 * (torque[k] + torque[k + 1]) - damping)
        psi = psi + 0.5 * step * (before + r)
        off_before = off_r
        off_r = decay * off_r + gain * sigma
        off_psi = off_psi + 0.5 * step * (off_before + off_r)
        # x' = A x with A = [[decay, 0, gain], [step, 1, 0], [0, 0, stays]], and fresh noise in w.
        rr, rp, rw, pp, pw = (
            decay * decay * rr + 2.0 * decay * gain * rw + gain * gain * ww,
            step * decay * rr + decay * rp + step * gain * rw + gain * pw,
            stays * (decay * rw + gain * ww),
            step * step * rr + 2.0 * step * rp + pp,
            stays * (step * rw + pw),
        )
        ww = stays * stays * ww + fresh
    return Runs(out[0], out[1], out[2], out[3])
