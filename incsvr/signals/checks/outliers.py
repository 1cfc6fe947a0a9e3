"""The share of values that have nothing to do with their neighbours; a yaw rate that scatters too far."""

from __future__ import annotations

import numpy as np

from incsvr.samples import Samples
from incsvr.signals.checks.stuck import CALLED
from incsvr.signals.checks.verdict import Decision, Finding
from incsvr.signals.raw import COUNT, HIGH, LOW, SPIKES, named
from incsvr.signals.settings import YAW_RATE

SHARE = {Decision.WARN: 0.04, Decision.PAUSE: 0.065}
"""The part of a batch's values from which on outliers are said, and from which on nothing is learned: of windows of 36
values each holds several then, and about half of them stand beside each other, where no neighbour tells."""


def outliers(batch: Samples) -> list[Finding]:
    """The streams of a batch that have too many of them."""
    found = []
    for name, called in CALLED.items():
        count = float(batch.raw[named(name, COUNT)].sum())
        share = float(batch.raw[named(name, SPIKES)].sum()) / count
        decision = max((each for each, least in SHARE.items() if share >= least), default=Decision.CLEAN)
        if decision:
            found.append(
                Finding(
                    f"{name} outliers",
                    decision,
                    f"{100.0 * share:.0f} % of the {called}'s values are outliers from {batch.time[0]:.10g} to "
                    f"{batch.time[-1]:.10g} s; check the sensor and its wiring",
                )
            )
    return found


def scatter(batch: Samples, largest_rate: float) -> list[Finding]:
    """Whether the yaw rate reaches over half of all rates within most windows: two gyros on one key, or a broken one.

    A vehicle that turned so quickly would be smoothed to nothing, and what is left would be no rate of anything.
    """
    within = float(np.median(batch.raw[named(YAW_RATE, HIGH)] - batch.raw[named(YAW_RATE, LOW)]))
    if within < largest_rate:
        return []
    return [
        Finding(
            "yaw_rate scatter",
            Decision.PAUSE,
            f"the yaw rate goes to and fro by {within:.3g} rad/s within each sample from {batch.time[0]:.10g} to "
            f"{batch.time[-1]:.10g} s; do two sensors send on one key, or is signals.smoothing too long?",
        )
    ]
