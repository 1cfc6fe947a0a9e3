"""Damping that drives the vehicle: Σ d·r Δt is the energy that it takes away, and it can give none.

Three things feign a little of the opposite: noise, an inertia that is declared wrong (its kinetic energy moves to and
fro), and water that moves a vehicle which a controller holds. Each is small beside a vehicle's own turning.
"""

from __future__ import annotations

import numpy as np

from incsvr.checks.verdict import Decision, Finding
from incsvr.numerics import Array, independent_part, robust_deviation, root_mean_square
from incsvr.signals.raw import TORQUE
from incsvr.signals.samples import Samples

ENERGY_SIGMAS = 6.0
"""Standard deviations of the noise that the energy is beyond."""
MIN_TURNING_RATE_SHARE = 0.15
"""Root-mean-square yaw rate, as a share of the vehicle's largest, from which on a batch counts as turning."""
WRONG_POWER_SHARE = 0.5
"""Part of all power to and fro that goes the wrong way: torque that comes late feigns it around each reversal."""
MIN_FOLLOWING_T = 1.0
"""Student's t from which on the yaw rate follows the torque the right way. Over 78 missions it was 2 to 5 where the
damping of a batch seemed to drive, since a controller answered the water, and at most 0.4 with a sign reversed."""
MIN_TURNED_SHARE = 0.285
"""Part of what the torque gave over a stretch, ∫ τ dt, that I Δr is at least where the vehicle is only turned round: in
41 reversals of a measured ship, whose sway takes most of her rudder's moment, it was 0.29 to 0.73; of thrusters that
are off it is none, and of an AUV's sway under a Coriolis force as large as its thrust 0.28."""

MIN_ONE_SIDED_SHARE = 1.0 / 3.0
"""Part of the samples in which the torque keeps its side, at least."""


def drives(batch: Samples, inertia: float, largest_rate: float) -> list[Finding]:
    """Whether the damping of a batch, or of one of its halves, drives the vehicle.

    Args:
        batch: n samples.
        inertia: as declared [kg m²].
        largest_rate: that the vehicle reaches [rad/s].
    """
    half = len(batch) // 2
    for part in (batch, batch.take(slice(0, half)), batch.take(slice(half, None))):
        if _drives(part, inertia, largest_rate):
            return [
                Finding(
                    "sign",
                    Decision.PAUSE,
                    f"the damping drives the vehicle from {part.time[0]:.10g} to {part.time[-1]:.10g} s, "
                    "which is impossible: {effort} and {rate} count in opposite directions; turn the sign of one "
                    "of them",
                )
            ]
    return []


def turns(batch: Samples, largest_rate: float) -> bool:
    """Whether the vehicle is driven to turn, not only moved by the water."""
    return len(batch) > 0 and root_mean_square(batch.yaw_rate) > MIN_TURNING_RATE_SHARE * largest_rate


def turned_round(part: Samples, inertia: float) -> bool:
    """Whether the torque, while it kept its side for longest, turned the vehicle towards it."""
    side = np.sign(part.raw[TORQUE])
    longest = max(np.split(np.arange(side.size), np.flatnonzero(np.diff(side)) + 1), key=len)
    return longest.size >= max(2.0, MIN_ONE_SIDED_SHARE * side.size) and follows(part.take(longest), inertia)


def follows(part: Samples, inertia: float) -> bool:
    """Whether the vehicle turned to where the torque pushed it, by how much that gave."""
    torque, rate = part.raw[TORQUE], part.yaw_rate
    given = float(np.sum(0.5 * (torque[1:] + torque[:-1]) * np.diff(part.time)))  # [N m s]
    return inertia * float(rate[-1] - rate[0]) * float(np.sign(given)) >= MIN_TURNED_SHARE * abs(given) > 0.0


def _drives(part: Samples, inertia: float, largest_rate: float) -> bool:
    if len(part) < 2 or not turns(part, largest_rate) or turned_round(part, inertia):
        return False
    power = part.damping * part.yaw_rate
    period = float(np.median(np.diff(part.time)))
    stored = 0.5 * inertia * float(np.max(part.yaw_rate**2))
    noise = ENERGY_SIGMAS * _noise(part.damping) * float(np.sqrt(np.sum(part.yaw_rate**2)))
    enough = max(noise, stored / period, WRONG_POWER_SHARE * float(np.sum(np.abs(power))))
    return float(np.sum(power)) < -enough and answer(part) < MIN_FOLLOWING_T


def answer(part: Samples) -> float:
    """Student's t of the torque in I ṙ = b τ + c₀ + c₁ r + c₂ r|r|: where a controller answers the water, Σ d·r says
    little of the signs, but ṙ follows the torque all the same."""
    rate, torque = part.yaw_rate, part.raw[TORQUE]
    drag = np.stack((np.ones(rate.size), rate, rate * np.abs(rate)), axis=1)
    drag, _ = np.linalg.qr(drag)
    alone = torque - drag @ (drag.T @ torque)
    taken_up = torque - part.damping
    power = float(alone @ alone)
    if rate.size <= drag.shape[1] + 1 or not power > 0.0:
        return 0.0
    slope = float(alone @ taken_up) / power
    left = taken_up - drag @ (drag.T @ taken_up) - slope * alone
    spread = float(left @ left) / (rate.size - drag.shape[1] - 1)
    beside = float(left[1:] @ left[:-1])
    correlation = max(beside / float(left @ left), 0.0) if spread > 0.0 else 0.0
    worth = independent_part(correlation)
    return slope * float(np.sqrt(worth * power / spread)) if spread > 0.0 else float(np.copysign(np.inf, slope))


def _noise(damping: Array) -> float:
    """Scatter of neighbours [N m], robust against outliers."""
    return robust_deviation(np.diff(damping)) / float(np.sqrt(2.0))
