"""Free runs side by side with what makes them uncertain: the water, and the doubt of the curve itself.

    I ṙ = τ − d(r) + w,  ψ̇ = r,  w a first-order Gauss–Markov process

Where damping goes by other velocities, too, these are given along the runs; traced effects stand between τ and what
drives (`incsvr.forecasting.effects_ahead`).

The mean follows an exponential (Rosenbrock–Euler) step, which is stable for any step and exact where d is a line. The
covariance of (r, ψ, w) follows the same linearisation. The doubt of the curve is no noise: it is off to one side for
long, so that it is carried as a sensitivity and its square added.

Source: M. Hochbruck, A. Ostermann, Exponential integrators, Acta Numerica 19, 2010, eq. (1.6); A. Gelb (ed.), Applied
Optimal Estimation, 1974, ch. 3.8 (shaping filters).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from incsvr.forecasting.damping_tables import Curve, CurveAmongOthers
from incsvr.numerics import Array

if TYPE_CHECKING:
    from incsvr.forecasting.effects_ahead import EffectsAhead


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


def propagate(
    curve: Curve | CurveAmongOthers,
    rate: Array,
    rate_sigma: float,
    torque: Array,
    step: float,
    effects: EffectsAhead | None = None,
) -> Runs:
    """n free runs of the same length.

    Args:
        rate: (n,) where they start [rad/s].
        rate_sigma: how well that is known [rad/s].
        torque: (steps + 1, n) at the ends of the steps, linear between [N m]; with effects what acts beside their
            thrust.
        step: [s].
        effects: traced effects along these runs; None for none.
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
        before = r
        moment = 0.5 * (torque[k] + torque[k + 1])
        damping, slope, sigma = curve.at(r, k)
        if effects is not None:
            driving, falls = effects.at(k, r, psi)
            moment, slope = moment + driving, np.maximum(slope + falls, 0.0)
        decay = np.exp(-slope * step / curve.inertia)
        gain = np.where(slope != 0.0, (1.0 - decay) / np.where(slope == 0.0, 1.0, slope), step / curve.inertia)
        r = r + gain * (moment - damping)
        if effects is not None:
            effects.moved(0.5 * (before + r), step)
        psi = psi + 0.5 * step * (before + r)
        off_before = off_r
        off_r = decay * off_r + gain * sigma
        off_psi = off_psi + 0.5 * step * (off_before + off_r)
        rr, rp, rw, pp, pw = _covariance_after((rr, rp, rw, pp, pw), ww, decay, gain, step, stays)
        ww = stays * stays * ww + fresh
    return Runs(out[0], out[1], out[2], out[3])


def _covariance_after(
    before: tuple[Array, Array, Array, Array, Array],
    ww: Array | float,
    decay: Array,
    gain: Array,
    step: float,
    stays: float,
) -> tuple[Array, Array, Array, Array, Array]:
    """The covariances rr, rp, rw, pp, pw of (r, ψ, w) after a step x' = A x, A = [[decay, 0, gain], [step, 1, 0],
    [0, 0, stays]]."""
    rr, rp, rw, pp, pw = before
    return (
        decay * decay * rr + 2.0 * decay * gain * rw + gain * gain * ww,
        step * decay * rr + decay * rp + step * gain * rw + gain * pw,
        stays * (decay * rw + gain * ww),
        step * step * rr + 2.0 * step * rp + pp,
        stays * (step * rw + pw),
    )
