"""A torque that turns nothing: thrusters that are off while commands go on, or a vehicle that something holds.

Near rest the water's drag is small, and what the torque does not spend on it turns the vehicle. Where it stays near
rest under torques that else drive it at some pace, the torque is not what acts on it, or not alone; a drag of this size
at rest would be learned from nothing.
"""

from __future__ import annotations

import numpy as np

from incsvr.samples import Samples
from incsvr.signals.checks.power import MOVING
from incsvr.signals.checks.verdict import Decision, Finding
from incsvr.signals.raw import TORQUE

FEWEST = 8
"""Samples in a row: a vehicle that is turned round passes rest within two or three."""
DRIVES = 0.4
"""The part of the largest damping that the torque is in the median: so near rest a linear drag takes MOVING of it, dry
friction some more."""
PASSES = 4.0
"""Times as long as the declared inertia alone takes from one side of rest to the other under the torque, that a stretch
lasts at least: a ship whose sway takes most of the torque, or an inertia that is declared too small, turns round more
slowly, and the torque turns it all the same."""


def unmoved(batch: Samples, largest_rate: float, largest_damping: float, inertia: float = 0.0) -> list[Finding]:
    """The longest stretch of a batch in which the torque turned nothing.

    Args:
        largest_rate: that the vehicle reaches [rad/s].
        largest_damping: that was learned [N m].
        inertia: as declared [kg m²], by which it is known how long a reversal takes; 0 where it is not.
    """
    still = np.flatnonzero(np.abs(batch.yaw_rate) < MOVING * largest_rate)
    runs = np.split(still, np.flatnonzero(np.diff(still) > 1) + 1)
    stretch = max(runs, key=len)
    if stretch.size < FEWEST:
        return []
    torque = batch.raw[TORQUE][stretch]
    push = float(np.median(np.abs(torque)))
    first, last = batch.time[stretch[0]], batch.time[stretch[-1]]
    passes = inertia * 2.0 * MOVING * largest_rate  # [N m s]
    if push < DRIVES * largest_damping or (last - first) * push < PASSES * passes:
        return []
    return [
        Finding(
            "unmoved",
            Decision.PAUSE,
            f"the torque reaches {float(torque[np.argmax(np.abs(torque))]):.3g} N m from {first:.10g} to {last:.10g} s "
            "while the vehicle hardly turns: the thrusters are off (disarmed?), or something holds it",
        )
    ]
