"""The share of values that have nothing to do with their neighbours; a yaw rate that scatters too far."""

from __future__ import annotations

import numpy as np

from incsvr.checks.frozen_stream import STREAM_WORDS
from incsvr.checks.verdict import Decision, Finding
from incsvr.signals.raw import COUNT, HIGH, LOW, MOVE, SPIKES, named
from incsvr.signals.samples import Samples
from incsvr.signals.settings import YAW_RATE

OUTLIER_SHARES = {Decision.WARN: 0.04, Decision.PAUSE: 0.065}
"""Shares of a batch's values from which on outliers are said, and from which on nothing is learned: of windows of 36
values each holds several then, and about half of them stand beside each other, where no neighbour tells."""

TO_AND_FRO_STEP_SHARE = 0.4
"""Mean step from one value to the next, as a part of what the values of a window span, from which on they go to and
fro: two gyros in turn take half of it or all, noise at most 0.31 in 18 values or more, a small vehicle that turns back
within the window at every fifth value 0.25."""


def outliers(batch: Samples) -> list[Finding]:
    """The streams of a batch that have too many of them."""
    found = []
    for name, called in STREAM_WORDS.items():
        count = float(batch.raw[named(name, COUNT)].sum())
        share = float(batch.raw[named(name, SPIKES)].sum()) / count
        decision = max((each for each, least in OUTLIER_SHARES.items() if share >= least), default=Decision.CLEAN)
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
    """Whether the yaw rate alternates over half of all rates within most windows: two gyros on one key."""
    span = batch.raw[named(YAW_RATE, HIGH)] - batch.raw[named(YAW_RATE, LOW)]
    within, move = float(np.median(span)), float(np.median(batch.raw[named(YAW_RATE, MOVE)]))
    if within < largest_rate or move < TO_AND_FRO_STEP_SHARE * within:
        return []
    return [
        Finding(
            "yaw_rate scatter",
            Decision.PAUSE,
            f"the {{rate}} alternates by {within:.3g} {{rate_unit}} within each sample from {batch.time[0]:.10g} to "
            f"{batch.time[-1]:.10g} s; check whether two sensors send on one key",
        )
    ]
