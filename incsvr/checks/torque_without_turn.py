"""A torque that turns nothing: thrusters that are off while commands go on, or a vehicle that something holds.

Near rest the water's drag is small, and what the torque does not spend on it turns the vehicle. Where it stays near
rest under torques that else drive it at some pace, the torque is not what acts on it, or not alone; a drag of this size
at rest would be learned from nothing.
"""

from __future__ import annotations

import numpy as np

from incsvr.checks.power import MIN_TURNING_RATE_SHARE, follows
from incsvr.checks.verdict import Decision, Finding
from incsvr.signals.raw import TORQUE
from incsvr.signals.samples import Samples

MIN_SAMPLES = 8
"""Samples in a row at rest: a vehicle that is turned round passes rest within two or three."""
DRIVING_TORQUE_SHARE = 0.4
"""Part of the largest damping that the torque is in the median: so near rest a linear drag takes
MIN_TURNING_RATE_SHARE of it, dry friction some more."""


def unmoved(batch: Samples, largest_rate: float, largest_damping: float, inertia: float = 0.0) -> list[Finding]:
    """The longest stretch of a batch in which the torque turned nothing.

    Args:
        largest_rate: that the vehicle reaches [rad/s].
        largest_damping: that was learned [N m].
        inertia: as declared [kg m²], by which a reversal is known; 0 knows none.
    """
    still = np.flatnonzero(np.abs(batch.yaw_rate) < MIN_TURNING_RATE_SHARE * largest_rate)
    runs = np.split(still, np.flatnonzero(np.diff(still) > 1) + 1)
    stretch = max(runs, key=len)
    if stretch.size < MIN_SAMPLES:
        return []
    torque = batch.raw[TORQUE][stretch]
    # a torque that alternates quickly turns the vehicle to and fro, and is none that the inertia leaves over
    left = np.minimum(np.abs(torque), np.abs(batch.damping[stretch]))
    if float(np.median(left)) < DRIVING_TORQUE_SHARE * largest_damping:
        return []
    if follows(batch.take(stretch), inertia):
        return []
    first, last = batch.time[stretch[[0, -1]]]
    return [
        Finding(
            "unmoved",
            Decision.PAUSE,
            f"the {{effort}} reaches {float(torque[np.argmax(np.abs(torque))]):.3g} {{effort_unit}} from {first:.10g} "
            f"to {last:.10g} s while the vehicle hardly {{turns}}: the thrusters are off (disarmed?), or something "
            "holds it",
        )
    ]
