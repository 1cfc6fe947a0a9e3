"""Damping that drives the vehicle: Σ d·r Δt is the energy that it takes away, and it can give none.

Three things feign a little of the opposite: noise, an inertia that is declared wrong (its kinetic energy moves to and
fro), and water that moves a vehicle which a controller holds. Each is small beside a vehicle's own turning.
"""

from __future__ import annotations

import numpy as np

from incsvr.samples import Array, Samples
from incsvr.signals.checks.verdict import Decision, Finding

CERTAIN = 6.0
"""Standard deviations of the noise that the energy is beyond."""
MOVING = 0.15
"""The root-mean-square yaw rate, as a part of the vehicle's largest, from which on a batch counts as turning."""
ONE_SIDED = 0.5
"""The part of all power to and fro that goes the wrong way: torque that comes late feigns it around each reversal."""


def drives(batch: Samples, inertia: float, largest_rate: float) -> list[Finding]:
    """Whether the damping of a batch, or of one of its halves, drives the vehicle.

    Args:
        batch: n samples.
        inertia: as declared [kg m²].
        largest_rate: that the vehicle reaches [rad/s].
    """
    half = len(batch) // 2
    for part in (slice(0, None), slice(0, half), slice(half, None)):
        if _drives(batch.take(part), inertia, largest_rate):
            return [
                Finding(
                    "sign",
                    Decision.PAUSE,
                    f"the damping drives the vehicle from {batch.time[part][0]:.10g} to {batch.time[part][-1]:.10g} s, "
                    "which no water can: torque and yaw rate count in opposite directions; turn the sign of one of "
                    "them",
                )
            ]
    return []


def turns(batch: Samples, largest_rate: float) -> bool:
    """Whether the vehicle is driven to turn, not only moved by the water."""
    return len(batch) > 0 and float(np.sqrt(np.mean(batch.yaw_rate**2))) > MOVING * largest_rate


def _drives(part: Samples, inertia: float, largest_rate: float) -> bool:
    if len(part) < 2 or not turns(part, largest_rate):
        return False
    power = part.damping * part.yaw_rate
    period = float(np.median(np.diff(part.time)))
    stored = 0.5 * inertia * float(np.max(part.yaw_rate**2))
    noise = CERTAIN * _noise(part.damping) * float(np.sqrt(np.sum(part.yaw_rate**2)))
    enough = max(noise, stored / period, ONE_SIDED * float(np.sum(np.abs(power))))
    return float(np.sum(power)) < -enough


def _noise(damping: Array) -> float:
    """Scatter of neighbours [N m], robust against outliers."""
    return 1.4826 * float(np.median(np.abs(np.diff(damping)))) / float(np.sqrt(2.0))
