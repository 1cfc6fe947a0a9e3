"""A torque that acts so late that it seems to count against the yaw rate: judged before its sign is blamed.

τ(t − D) = I ṙ + b r + c r|r| + d by least squares, over delays D. Where a vehicle turns against its torque at D = 0 and
follows it at some D > 0 far better than it ever turns against it, the stamps are late and the sign is right.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from incsvr.samples import Array, Samples
from incsvr.signals.raw import TORQUE

DELAYS: Array = np.arange(0.0, 1.01, 0.05, dtype=np.float64)
"""Of the torque, that are tried [s]: rotors, links and clocks make some tenths; a longer one is half a turn of many
vehicles, whose sign no delay tells."""
SEEMS = 0.3
"""Part of the torque that it must explain against the yaw rate before its sign is looked at."""
BETTER = 0.05
"""Part of the torque by which the right sign must explain more than the wrong one at any shorter delay: of one sine
both explain nearly the same."""


def late_torque(samples: Samples, inertia: float, torque_at: Callable[[Array], Array]) -> float | None:
    """By how much the torque acts after its stamps [s], where that alone turns its sign; None where it does not.

    Args:
        samples: n of them, made with this inertia [kg m²].
        torque_at: the filtered torque [N m] at (n,) instants [s]; NaN where it is not known.
    """
    slope = (samples.raw[TORQUE] - samples.damping) / inertia
    along = np.array([_follows(slope, samples.yaw_rate, torque_at(samples.time - delay)) for delay in DELAYS])
    with_it, against = np.maximum(along, 0.0), np.maximum(-along, 0.0)
    best = int(np.argmax(with_it))
    if against[0] < SEEMS or with_it[best] < float(np.max(against[: best + 1])) + BETTER:
        return None
    return float(DELAYS[best])


def _follows(slope: Array, rate: Array, torque: Array) -> float:
    """Part of the torque that acceleration and drag explain: negative where both count against it, 0 where they are at
    odds."""
    known = np.isfinite(torque)
    if np.count_nonzero(known) < 10:
        return 0.0
    slope, rate, torque = slope[known], rate[known], torque[known]
    design = np.column_stack([slope, rate, np.ones(rate.size)])
    theta = np.linalg.lstsq(design, torque)[0]
    left = torque - design @ theta
    explained = 1.0 - float(left @ left) / max(float(torque @ torque), 1e-300)
    if theta[0] > 0.0 and theta[1] > 0.0:
        return explained
    return -explained if theta[0] < 0.0 and theta[1] < 0.0 else 0.0
