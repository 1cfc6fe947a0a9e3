"""A yaw rate in another unit: the vehicle would take up more energy than any torque gave it."""

from __future__ import annotations

import numpy as np

from incsvr.samples import Samples
from incsvr.signals.checks.power import MOVING
from incsvr.signals.checks.verdict import Decision, Finding
from incsvr.signals.raw import TORQUE

EXCEEDS = 5.0
"""How many times the torque's work the kinetic energy grows: a declared inertia may be wrong by some tenths, a yaw rate
in degrees per second makes 57 of it."""


def unit(batch: Samples, inertia: float, largest_rate: float) -> list[Finding]:
    """Whether the yaw rate of a batch can be in rad/s.

    Args:
        inertia: as declared [kg m²].
        largest_rate: that the vehicle reaches [rad/s].
    """
    rate, torque = batch.yaw_rate, batch.raw[TORQUE]
    if len(batch) < 2 or float(np.max(np.abs(rate))) < 2.0 * MOVING * largest_rate:
        return []
    energy = 0.5 * inertia * rate**2
    gained = float(np.max(energy - np.minimum.accumulate(energy)))
    work = float(np.median(np.diff(batch.time))) * float(np.sum(np.abs(torque * rate)))
    if gained <= EXCEEDS * work:
        return []
    return [
        Finding(
            "unit",
            Decision.PAUSE,
            f"the yaw rate grows to {float(np.max(np.abs(rate))):.3g} rad/s from {batch.time[0]:.10g} to "
            f"{batch.time[-1]:.10g} s, which takes {gained:.3g} J where the torque did {work:.3g}: is "
            "it in degrees per second, the torque in another unit, or "
            f"the inertia not {inertia:g} kg m²?",
        )
    ]
