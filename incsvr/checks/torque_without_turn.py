"""A torque that turns nothing: thrusters that are off while commands go on, or a vehicle that something holds.

Near rest the water's drag is small, and what the torque does not spend on it turns the vehicle. Where it stays near
rest under torques that else drive it at some pace, the torque is not what acts on it, or not alone; a drag of this size
at rest would be learned from nothing.
"""

from __future__ import annotations

import numpy as np

from incsvr.checks.power import MIN_TURNING_RATE_SHARE
from incsvr.checks.verdict import Decision, Finding
from incsvr.signals.raw import TORQUE
from incsvr.signals.samples import Samples

MIN_SAMPLES = 8
"""Samples in a row at rest: a vehicle that is turned round passes rest within two or three."""
DRIVING_TORQUE_SHARE = 0.4
"""Part of the largest damping that the torque is in the median: so near rest a linear drag takes
MIN_TURNING_RATE_SHARE of it, dry friction some more."""
MIN_TURNED_SHARE = 0.285
"""Part of what the torque gave over a stretch, ∫ τ dt, that I Δr is at least where the vehicle is only turned round: in
41 reversals of a measured ship, whose sway takes most of her rudder's moment, it was 0.29 to 0.73; of thrusters that
are off it is none, and of an AUV's sway under a Coriolis force as large as its thrust 0.28."""


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
    if float(np.median(np.abs(torque))) < DRIVING_TORQUE_SHARE * largest_damping:
        return []
    time, rate = batch.time[stretch], batch.yaw_rate[stretch]
    given = float(np.sum(0.5 * (torque[1:] + torque[:-1]) * np.diff(time)))  # [N m s]
    if inertia * float(rate[-1] - rate[0]) * np.sign(given) >= MIN_TURNED_SHARE * abs(given) > 0.0:
        return []
    first, last = time[0], time[-1]
    return [
        Finding(
            "unmoved",
            Decision.PAUSE,
            f"the {{effort}} reaches {float(torque[np.argmax(np.abs(torque))]):.3g} {{effort_unit}} from {first:.10g} "
            f"to {last:.10g} s while the vehicle hardly {{turns}}: the thrusters are off (disarmed?), or something "
            "holds it",
        )
    ]
