"""How the yaw rate answers the noise of a block, which a fit must know where its columns hold the motion.

What the equations do not predict of a block, e, is no disturbance that sets in with the block and stays: one that
lasts has begun before, unseen in the mean of the block before, and grows on. The rate has answered it since, and a
controller has answered the rate.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from incsvr.tracing.run import Array

PARTS = 16
"""Of a block, in which disturbance and rate are followed."""

BEFORE = 3
"""Blocks before that predict a block: the order of the noise's AR."""

SLOWEST = 1e-4
"""Fading in a block below which the rate runs as if none."""

WHITE = 0.02
"""Autocorrelation of the blocks below which nothing lasts from one to the next."""

FADES = (1e-4, 60.0)
"""Least and most by which a disturbance may fade within a block, as exponents."""


@dataclass(frozen=True, slots=True)
class DisturbanceResponse:
    """The yaw rate's answer per N m of e.

    Attributes:
        rise: (n_b,) of the rate over the block [rad/s], less what the blocks before predict of it.
        rate_within: (n_b, PARTS) the rate within the block [rad/s], likewise.
        path: ((BEFORE + 1) PARTS + 1,) the rate from where the blocks before begin to the end of the block, all of it,
            for a mean block.
        predictor: (BEFORE,) what the blocks before, oldest first, predict of a block.
    """

    rise: Array
    rate_within: Array
    path: Array
    predictor: Array

    @property
    def mean(self) -> Array:
        """(n_b,) the rate in the mean over the block [rad/s]."""
        mean: Array = self.rate_within.mean(axis=1)
        return mean

    def left(self, path: Array) -> float:
        """Mean of a path over its last block, less what those before predict of it."""
        means = (0.5 * (path[1:] + path[:-1])).reshape(BEFORE + 1, PARTS).mean(axis=1)
        return float(means[-1] - self.predictor @ means[:-1])


def disturbance_response(
    slope: Array, feedback: float, ar: Array, torque_noise_fraction: float, period: float, inertia: float
) -> DisturbanceResponse:
    """The answer to noise of the colour that an AR(3) over blocks tells.

    That is a disturbance which fades exponentially, beside white noise, as lag one and two of the blocks tell; of the
    white part what is no noise of the torque turns the vehicle, too. All is per N m of what I₀ Δr/T_b − τ shows of e:
    the damping takes the rest, but is itself what a fit looks for.

    Args:
        slope: (n_b,) d'(r) of the damping [N m s/rad].
        feedback: K of a controller [N m s/rad].
        ar: (3,) of the blocks.
        torque_noise_fraction: of e, 0…1, that is noise of the torque.
        period: of a block [s].
        inertia: I₀ [kg m²].
    """
    shape, predictor = _unforeseen(ar, torque_noise_fraction)
    # of less fading numbers would not be left
    fading = np.maximum((slope + feedback) * period / inertia, SLOWEST) / PARTS
    keeps, gains = np.exp(-fading), period / PARTS / inertia * -np.expm1(-fading) / fading
    rate = np.zeros((shape.size + 1, slope.size))
    for k, moment in enumerate(shape):
        rate[k + 1] = keeps * rate[k] + gains * moment
    whitened = np.append(-predictor, 1.0)
    rise = whitened @ np.diff(rate[::PARTS], axis=0)
    within = 0.5 * (rate[1:] + rate[:-1])
    rate_within = np.tensordot(whitened, within.reshape(BEFORE + 1, PARTS, slope.size), axes=1)
    shown = 1.0 - slope * rate_within.mean(axis=0)
    return DisturbanceResponse(rise / shown, (rate_within / shown).T, (rate / shown).mean(axis=1), predictor)


def _unforeseen(ar: Array, torque_noise_fraction: float) -> tuple[Array, Array]:
    """((BEFORE + 1) PARTS,) what disturbance to expect there per unit of e in its block, and (BEFORE,) what predicts
    the block's mean, oldest first."""
    parts = (BEFORE + 1) * PARTS
    first, second = _autocorrelation(ar)
    if first < WHITE:
        return np.repeat([0.0, 1.0], [BEFORE * PARTS, PARTS]), np.zeros(BEFORE)
    fades = float(np.clip(-np.log(np.clip(second / first, 1e-9, 1.0)), *FADES))
    lasting = first / _kept(fades)
    if lasting > 1.0:  # lag one alone tells it
        lasting = 1.0
        fades = float(brentq(lambda x: _kept(x) - first, *FADES)) if first < _kept(FADES[0]) else FADES[0]
    time = (np.arange(parts) + 0.5) / PARTS
    together = np.exp(-fades * np.abs(time[:, None] - time[None, :]))
    mean = np.kron(np.eye(BEFORE + 1), np.full(PARTS, 1.0 / PARTS))
    blocks = mean @ together @ mean.T
    white = blocks[0, 0] * (1.0 / lasting - 1.0)
    seen = blocks + white * np.eye(BEFORE + 1)
    predictor = np.linalg.solve(seen[:BEFORE, :BEFORE], seen[:BEFORE, BEFORE])
    unforeseen = np.append(-predictor, 1.0)
    turning = white - min(white, torque_noise_fraction * float(unforeseen @ seen @ unforeseen))
    shape = together @ mean.T @ unforeseen + turning * np.repeat(unforeseen, PARTS)
    return shape / shape[-PARTS:].mean(), predictor


def _kept(fades: float) -> float:
    """Autocorrelation of the means of neighbouring blocks of a disturbance that fades by exp(−`fades`) in each."""
    return float(np.expm1(-fades) ** 2 / (2.0 * (fades + np.expm1(-fades))))


def _autocorrelation(ar: Array) -> tuple[float, float]:
    """Of an AR(3), at lag one and two (Yule-Walker)."""
    a, b, c = ar
    lags = np.linalg.solve([[1.0 - b, -c, 0.0], [-a - c, 1.0, 0.0], [-b, -a, 1.0]], ar)
    return float(lags[0]), float(lags[1])
