"""A torque that acts so late that it seems to count against the yaw rate: judged before its sign is blamed.

τ(t − D) = I ṙ + b r + c by least squares, over delays D. Where a vehicle turns against its torque at D = 0 and
follows it at some D > 0 far better than it ever turns against it, the stamps are late and the sign is right.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from incsvr.numerics import Array
from incsvr.signals.raw import TORQUE
from incsvr.signals.samples import Samples

DELAYS_S: Array = np.arange(0.0, 1.01, 0.05, dtype=np.float64)
"""Delays of the torque that are tried [s]: rotors, links and clocks make some tenths; a longer one is half a turn of
many vehicles, whose sign no delay tells."""
MIN_WRONG_SHARE = 0.3
"""Part of the torque that the wrong sign must explain against the yaw rate before the sign is looked at."""
MIN_BETTER_SHARE = 0.05
"""Part of the torque by which the right sign must explain more than the wrong one at any shorter delay: of one sine
both explain nearly the same."""


@dataclass(frozen=True, slots=True)
class TorqueSign:
    """The sign of a torque relative to a yaw rate, over delays.

    Attributes:
        opposes: part of the torque that acceleration and rate explain with both against it, at no or a shorter delay.
        follows: part that they explain with both along it, at the best delay.
        delay: that one [s].
    """

    opposes: float
    follows: float
    delay: float

    @property
    def late(self) -> bool:
        """Whether the torque is late and its sign right."""
        return self.follows >= self.opposes + MIN_BETTER_SHARE

    @property
    def may_be_late(self) -> bool:
        """Whether it is late where its sign is right."""
        return self.follows >= MIN_WRONG_SHARE


def torque_sign(samples: Samples, inertia: float, torque_at: Callable[[Array], Array]) -> TorqueSign | None:
    """The sign of the torque, if the vehicle seems to turn against it; else None.

    Args:
        samples: n of them, made with this inertia [kg m²].
        torque_at: the filtered torque [N m] at (n,) instants [s]; NaN where it is not known.
    """
    slope = (samples.raw[TORQUE] - samples.damping) / inertia
    along = np.array([_follows(slope, samples.yaw_rate, torque_at(samples.time - delay)) for delay in DELAYS_S])
    with_it, against = np.maximum(along, 0.0), np.maximum(-along, 0.0)
    best = int(np.argmax(with_it))
    until = best + 1 if with_it[best] > 0.0 else DELAYS_S.size
    if max(float(against[0]), float(np.max(against[:until]))) < MIN_WRONG_SHARE or with_it[0] > 0.0:
        return None
    return TorqueSign(float(np.max(against[:until])), float(with_it[best]), float(DELAYS_S[best]))


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
    about = torque - np.mean(torque)
    explained = 1.0 - float(left @ left) / max(float(about @ about), 1e-300)
    if theta[0] > 0.0 and theta[1] > 0.0:
        return explained
    return -explained if theta[0] < 0.0 and theta[1] < 0.0 else 0.0
