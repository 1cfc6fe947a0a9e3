"""Properties of the raw streams around each sample: the filter hides a sensor that is stuck, clipped or spiky.

Like the samples themselves, all of it depends on the values of a sample's own smoothing window alone, so that it is the
same live and from a file, and goes with the sample wherever that goes.
"""

from __future__ import annotations

import numpy as np

from incsvr.numerics import Array
from incsvr.signals.smoothing import Smoothed

TORQUE = "torque"
"""The filtered torque [N m]."""
LOW, HIGH, STEP, COUNT, SPIKES, PERIOD = "low", "high", "step", "count", "spikes", "period"
"""Names of a stream's figures, as in `Smoothed`."""
RATE_SPREAD, TORQUE_SLOPE = "yaw_rate:spread", "torque:slope"
"""The range of the yaw rate within the filter [rad/s], and the slope of the torque [N m/s],
where it is not known when."""
HEADING, HEADING_TIME = "heading", "heading_time"
"""The newest heading [rad], and its stamp [s]."""


def named(stream: str, what: str) -> str:
    """The name of a stream's figure."""
    return f"{stream}:{what}"


def around(stream: str, smoothed: Smoothed) -> dict[str, Array]:
    """The properties of a stream around each sample."""
    return {named(stream, what): getattr(smoothed, what) for what in (LOW, HIGH, STEP, COUNT, SPIKES, PERIOD)}


def newest(time: Array, value: Array, at: Array, oldest: float) -> dict[str, Array]:
    """The heading that was the newest at each instant (m,), and its stamp; NaN where it is older than `oldest` [s]."""
    if time.size == 0:
        return {}
    position = np.searchsorted(time, at, side="right") - 1
    stamp = time[np.maximum(position, 0)]
    there = (position >= 0) & (at - stamp <= oldest)
    return {
        HEADING: np.where(there, value[np.maximum(position, 0)], np.nan),
        HEADING_TIME: np.where(there, stamp, np.nan),
    }
