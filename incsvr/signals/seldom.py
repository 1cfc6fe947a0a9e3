"""Whether the streams come often enough for the vehicle that they show."""

from __future__ import annotations

from math import ceil

import numpy as np

from incsvr.samples import Array
from incsvr.signals.scales import time_scale

TOO_SLOW = 0.1
"""Period of the torque over the vehicle's time scale from which it is said. In 143 simulated recordings of 24 vehicles
(steps held for 0.8 to 2.4 s, torque at 1 to 20 Hz; seeds 780000 to 780023) a curve that was learned with the torque as
a measurement was off at its worst rate by less than a third below it, in nine of ten, and from 0.4 on by two thirds in
the median."""
REGULAR = 0.5
"""Spread of the middle eight tenths of the pauses over their median, below which a stream is sampled; what is sent on
change alone is known between its messages, too."""


def too_slow(rate: tuple[Array, Array], torque: tuple[Array, Array]) -> str | None:
    """A sentence with the cure where the torque is sampled too seldom for how fast the vehicle turns.

    Args:
        rate: stamps (n,) [s] and yaw rates [rad/s].
        torque: stamps (m,) [s] and torques [N m].
    """
    steps = np.diff(torque[0])
    if steps.size < 8 or rate[0].size < 4 or not np.ptp(torque[1]) > 0.0:
        return None
    period = float(np.median(steps))
    low, high = np.quantile(steps, (0.1, 0.9))
    even = float(np.median(np.diff(rate[0])))
    scale = time_scale([np.interp(np.arange(rate[0][0], rate[0][-1], even), *rate)], even)
    if high - low > REGULAR * period or period < TOO_SLOW * scale or scale <= 0.0:
        return None
    return (
        f"the torque comes every {period:.2g} s, too seldom for a vehicle whose yaw rate changes within {scale:.2g} s: "
        f"what is told between is not known; record it at {ceil(1.0 / (TOO_SLOW * scale))} Hz or more (on ArduPilot by "
        "the message interval of SERVO_OUTPUT_RAW, or from the vehicle's own .BIN)"
    )
