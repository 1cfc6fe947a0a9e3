"""A yaw rate that leaps to and fro between messages: a loose connector, a value that falls to zero for a moment.

A few samples of a batch are off by far, to both sides, while the others follow the learned curve: what leaps away
comes back. A vehicle that changed is off in one direction, or as its damping is. But thrust that comes late, or no
longer does, is off to both sides too, after every jump of the command: so this warns and does not stop the learning.
"""

from __future__ import annotations

import numpy as np

from incsvr.checks.curve import Curve
from incsvr.checks.verdict import Decision, Finding
from incsvr.numerics import Array
from incsvr.signals.samples import Samples

GROSS_ERROR_NOISES = 8.0
"""Noise levels beyond which a sample is off by far."""
GROSS_ERROR_SHARES = (0.1, 0.5)
"""Shares of the samples that are off by far: from the first on they are no single ones, up to the second they are not
the rest."""
MAX_SUM_SHARE = 0.5
"""Part of what they are off by that their sum is at most: what leaps and comes back cancels."""
MAX_REST_NOISES = 2.0
"""Noise levels that the others are off by at most, in their median."""


def leaps(batch: Samples, curve: Curve) -> list[Finding]:
    """The share of a batch's samples at learned rates between which the yaw rate leaps."""
    inside = curve.inside
    left, damping = (batch.damping - curve.damping)[inside], curve.damping[inside]
    off = np.abs(left) > GROSS_ERROR_NOISES * curve.sigma
    if not left.size or not GROSS_ERROR_SHARES[0] <= float(np.mean(off)) < GROSS_ERROR_SHARES[1]:
        return []
    if float(np.median(np.abs(left[~off]))) > MAX_REST_NOISES * curve.sigma:
        return []
    if (
        _sided(left[off], np.ones(int(off.sum()))) > MAX_SUM_SHARE
        or _sided(left[off], np.sign(damping[off])) > MAX_SUM_SHARE
    ):
        return []
    return [
        Finding(
            "leaps",
            Decision.WARN,
            f"{100.0 * float(np.mean(off)):.0f} % of the samples from {batch.time[0]:.10g} to {batch.time[-1]:.10g} s "
            "deviate far, to both sides, and the others do not: the {rate} jumps, or the {effort} drops out briefly; "
            "check the sensors and their wiring",
        )
    ]


def _sided(left: Array, direction: Array) -> float:
    """The share of the residual that points one way along a direction: 1 if all does."""
    return abs(float(left @ direction)) / float(np.abs(left).sum())
