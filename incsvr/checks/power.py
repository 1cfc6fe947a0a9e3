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

ONE_SIDED_SHARE = 0.25
"""Part of the torque's impulses to both sides that is left of them where it is a torque to one side."""


def drives(batch: Samples, inertia: float, largest_rate: float) -> list[Finding]:
    """Whether the damping of a batch, or of one of its halves, drives the vehicle.

    Args:
        batch: n samples.
        inertia: as declared [kg m²].
        largest_rate: that the vehicle reaches [rad/s].
    """
    for part in with_halves(batch):
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


def with_halves(batch: Samples) -> tuple[Samples, ...]:
    """The samples, their first half and their second."""
    half = len(batch) // 2
    return batch, batch.take(slice(0, half)), batch.take(slice(half, None))


def turned_round(part: Samples, inertia: float) -> bool:
    """Whether a torque to one side turned the vehicle towards it, by how much it gave."""
    torque, rate = part.raw[TORQUE], part.yaw_rate
    gave = 0.5 * (torque[1:] + torque[:-1]) * np.diff(part.time)  # [N m s]
    given = float(np.sum(gave))
    to_one_side = abs(given) > ONE_SIDED_SHARE * float(np.sum(np.abs(gave)))
    return to_one_side and inertia * float(rate[-1] - rate[0]) * np.sign(given) >= MIN_TURNED_SHARE * abs(given)


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
