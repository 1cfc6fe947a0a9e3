"""Faults that begin seconds before the end of a batch: too short to be named, but the batch must wait.

The last samples are all off by far while those before follow the learned curve. Where a vehicle that changed would be
like this, the batch is learned: a hull that is mounted is no fault. Else the batch waits for the next one, which tells.
"""

from __future__ import annotations

import numpy as np

from incsvr.checks.misfit import BOUNDLESS_CHANGE, DRIVELESS_CHANGE, MAX_CHANGE_NOISES, UNCLEAR, Scales
from incsvr.checks.response import Residual
from incsvr.checks.verdict import Decision, Finding
from incsvr.numerics import Array, robust_deviation

LAST_SAMPLES = (8, 16)
"""Samples at the end of a batch that are looked at: four hold no two stray ones that make a median, more are a
window's."""
CALM_NOISES = 2.0
"""Noise levels that the samples before are off by at most, in their deviation."""
FAR_NOISES = 6.0
"""Noise levels that the last samples are off by at least."""
FAR_DAMPING_SHARE = 0.25
"""Part of the largest damping that the last samples are off by at least: half a dozen samples in a swell are off by
less, where whole batches are not."""
MIN_DAMPING_NOISES = 2.0
"""Damping over these samples, in noise levels, from which on a change of it would be seen."""


def onset(seen: Residual, scales: Scales) -> list[Finding]:
    """Whether what the curve leaves over of a batch's last samples is no vehicle's change."""
    for count in LAST_SAMPLES:
        if seen.time.size < 2 * count:
            return []
        left, damping, before = seen.left[-count:], seen.damping[-count:], seen.left[:-count]
        if _deviation(before[: -LAST_SAMPLES[0]]) > CALM_NOISES * scales.sigma:
            continue
        if _deviation(left) < max(FAR_NOISES * scales.sigma, FAR_DAMPING_SHARE * scales.largest_damping):
            continue
        power = float(damping @ damping)
        gain = float(damping @ left) / power if power > count * (MIN_DAMPING_NOISES * scales.sigma) ** 2 else np.inf
        rest = left - gain * damping if np.isfinite(gain) else left
        if DRIVELESS_CHANGE < gain < BOUNDLESS_CHANGE and _deviation(rest) < MAX_CHANGE_NOISES * scales.sigma:
            continue
        return [
            Finding(
                UNCLEAR,
                Decision.PAUSE,
                f"the residual of the learned curve is {_deviation(left):.3g} {{effort_unit}} since "
                f"{seen.time[-count]:.10g} s: a sensor failed or the vehicle changed; the next batch decides",
            )
        ]
    return []


def _deviation(rest: Array) -> float:
    return robust_deviation(rest) if rest.size else 0.0
