"""The inertia that torque and acceleration show by themselves, against which a declared one is judged.

Only a factor is judged so: hidden effects, a closed loop and noise move it by up to two.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from incsvr.signals.raw import TORQUE
from incsvr.signals.samples import Samples

FAR_FACTOR = 3.0
"""Factor between the declared inertia and the nearer end of what the motion shows, from which the declaration is said
to be wrong: hidden effects and a closed loop bring forth two."""
MIN_ACCELERATION_SHARE = 0.5
"""Part of what drag leaves of the torque that the acceleration must explain: a vehicle that turns steadily shows no
inertia."""
MIN_EXPLAINED_SHARE = 0.5
"""Part of the torque that acceleration and drag must explain before they say anything."""
MIN_SAMPLES = 30
"""Samples from which anything is told."""


@dataclass(frozen=True, slots=True)
class ApparentInertia:
    """The inertia that samples show.

    Attributes:
        low, high: between which inertias plain least squares puts the vehicle [kg m²].
        asked: root mean square of I ṙ with the declared inertia, in that of the torque.
        largest, smallest: the largest and the least torque [N m].
    """

    low: float
    high: float
    asked: float
    largest: float
    smallest: float

    @property
    def middle(self) -> float:
        """[kg m²]."""
        return float(np.sqrt(self.low * self.high))

    def contradicts(self, declared: float) -> bool:
        """Whether a declared inertia [kg m²] is wrong by a factor, or the torque is in another unit by as much."""
        return not self.low / FAR_FACTOR <= declared <= FAR_FACTOR * self.high


def apparent_inertia(samples: Samples, declared: float) -> ApparentInertia | None:
    """The inertia that n samples show, made with the `declared` one [kg m²] and with what their streams showed; None
    where they show none.

    τ = I ṙ + b r + c r|r| + d by least squares. Noise in ṙ lowers the I of τ on ṙ, noise in τ raises that of ṙ on τ:
    the truth lies between them (Frisch).
    """
    if TORQUE not in samples.raw or len(samples) < MIN_SAMPLES:
        return None
    torque, rate = samples.raw[TORQUE], samples.yaw_rate
    slope = (torque - samples.damping) / declared
    drag = np.column_stack([np.ones(rate.size), rate, rate * np.abs(rate)])
    turning, pushing = (values - drag @ np.linalg.lstsq(drag, values)[0] for values in (slope, torque))
    together, square, rest = float(turning @ pushing), float(turning @ turning), float(pushing @ pushing)
    if together <= 0.0 or rest <= 0.0:
        return None
    own = together**2 / (square * rest)
    explained = 1.0 - (1.0 - own) * rest / max(float(np.sum((torque - np.mean(torque)) ** 2)), 1e-300)
    if own < MIN_ACCELERATION_SHARE or explained < MIN_EXPLAINED_SHARE:
        return None
    asked = declared * float(np.sqrt(np.mean(slope**2) / np.mean(torque**2)))
    return ApparentInertia(together / square, together / square / own, asked, float(torque.max()), float(torque.min()))
