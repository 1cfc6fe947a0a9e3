"""Does the torque answer the water, and is it a command or a measurement?"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from incsvr.tracing.forward.fit import Fit
from incsvr.tracing.forward.grid import Grid
from incsvr.tracing.forward.thresholds import ANSWERS, NOISY

Array = NDArray[np.float64]

PAST, RUNNING, AHEAD = 9, (20.0, 100.0), (1, 3)
"""Cells of the torque's past, and of its running means, from which it is predicted; and by how many cells ahead."""


@dataclass(frozen=True, slots=True)
class Loop:
    """How the torque came about.

    Attributes:
        answer: deviations by which the torque follows what the innovations tell of the water; negative where the torque
            itself holds noise: that comes back to zero, and so against the innovation of its own cell.
    """

    answer: float

    @property
    def closed(self) -> bool:
        """Whether a controller closed the loop: the torque answers the water, and a free run proves nothing."""
        return self.answer > ANSWERS

    @property
    def commanded(self) -> bool:
        """Whether the torque is a command: no noise of its own is seen in it."""
        return self.answer > -NOISY


def loop_of(grid: Grid, base: Fit) -> Loop:
    """How the torque came about, as the declared model's innovations tell."""
    return Loop(_answer(grid, base))


def _answer(grid: Grid, base: Fit) -> float:
    """The strongest correlation of an innovation with what its own past does not predict of the torque after it, in
    standard errors.

    In open loop the torque may follow its own past, but nothing that the rate tells beside it, however wrong the model
    is; a controller follows the rate (P. E. Caines, C. W. Chan, IEEE Trans. Autom. Control 20, 1975). Water that pushes
    forward makes an innovation negative, the target being the torque that is missing, and a controller then takes
    torque away.
    """
    innovation, torque = np.sqrt(base.weight) * base.innovation, grid.command
    if float(np.ptp(torque)) == 0.0:
        return 0.0
    lags = [np.roll(torque, k) for k in range(PAST)]
    running = [lfilter([1.0 / length], [1.0, 1.0 / length - 1.0], torque) for length in RUNNING]
    past = np.stack([*lags, np.abs(torque), torque * np.abs(torque), *running, np.ones(torque.size)], axis=1)
    found = []
    for ahead in AHEAD:
        inside = np.concatenate([np.arange(a + PAST, b - ahead) for a, b in pairwise(grid.starts) if b - a > 2 * PAST])
        change = torque[inside + ahead] - torque[inside]
        left, usual = change, 0.0
        for _ in range(3):
            kept = np.abs(left) <= 3.0 * usual if usual > 0.0 else np.ones(change.size, dtype=bool)
            left = change - past[inside] @ np.linalg.lstsq(past[inside][kept], change[kept])[0]
            usual = 1.4826 * float(np.median(np.abs(left))) or float(np.std(left))
        left = np.clip(left, -3.0 * usual, 3.0 * usual)
        deviation = float(np.std(innovation)) * np.sqrt(float(left @ left))
        found.append(float(innovation[inside] @ left) / max(deviation, 1e-300))
    return float(max(found, key=abs))
