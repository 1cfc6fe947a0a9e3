"""Does the torque answer the water, is it a command or a measurement, and do the recordings say anything at all?"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from incsvr.errors import BadInput
from incsvr.tracing.fit import Fit
from incsvr.tracing.grid import Grid
from incsvr.tracing.search import Projection
from incsvr.tracing.thresholds import ANSWERS, DRIVES, IDLE, IDLE_RATE, LEAST_KNOWN, LEAST_RATE, REVERSED

Array = NDArray[np.float64]


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
        return self.answer > -ANSWERS


def loop_of(grid: Grid, base: Fit) -> Loop:
    """How the torque came about, as the declared model's innovations tell."""
    return Loop(_answer(grid, base))


def refuse_opposite_signs(grid: Grid, base: Fit) -> None:
    """Raises BadInput where the vehicle turns against its thrust: then more than all of the torque seems lost, or the
    damping drives the fastest turns both ways.
    """
    projection = Projection(grid, base)
    seen = projection.seen(grid.signals.torque)
    lost = float(projection.left @ seen) / max(float(seen @ seen), 1e-300)
    ends = np.asarray(np.quantile(grid.signals.rate, [0.01, 0.99]), dtype=np.float64)
    drives = np.min(-np.sign(ends) * base.model.damping_at(ends)) / np.sqrt(np.mean(grid.signals.torque**2))
    if lost > REVERSED or (ends[0] < 0.0 < ends[1] and drives > DRIVES):
        raise BadInput(
            "torque and yaw rate count in opposite directions (the vehicle turns against its thrust): multiply torque "
            "by −1, it must be positive the way yaw_rate is"
        )


def refuse_too_little_motion(grid: Grid, base: Fit) -> None:
    """Raises BadInput where the vehicle hardly moves, or its torque hardly moves it: there anything explains
    everything."""
    s = grid.signals
    if float(np.ptp(s.torque)) == 0.0:
        return  # what turns a vehicle whose thrusters stand still is another question
    fastest = float(np.quantile(np.abs(s.rate), 0.99))
    scatter = 1.4826 * float(np.median(np.abs(np.diff(s.rate, 3)))) / np.sqrt(20.0)
    unsure = _gain_error(grid, base)
    idle = float(np.mean(np.abs(s.torque) < 0.02 * max(float(np.max(np.abs(s.torque))), 1e-300)))
    least = IDLE_RATE if idle > IDLE else LEAST_RATE
    if unsure > LEAST_KNOWN or fastest < least * scatter:
        raise BadInput(
            f"too little motion: 99 % of the yaw rates are below {fastest:.2g} rad/s where the gyro scatters by "
            f"{scatter:.1g}, the torque is next to zero for {idle:.0%} of the time, and what it does would leave the "
            f"inertia uncertain by {min(unsure, 9.99):.0%}; drive turns both ways with steps of a quarter, half and "
            f"all of the torque, each held for {max(2.0 * s.scale, 5.0):.0f} s, for ten minutes"
        )


def _gain_error(grid: Grid, base: Fit) -> float:
    """Relative standard error of the thrust's gain beside a free damping."""
    seen = Projection(grid, base).seen(grid.signals.torque)
    return float(base.sigma / np.sqrt(max(float(seen @ seen), 1e-300)))


def _answer(grid: Grid, base: Fit) -> float:
    """The strongest correlation of an innovation with the torque's change after it, in standard errors.

    An innovation is new to everything before it, and in open loop to the torque after it, too: the torque follows it
    only through a controller (P. E. Caines, C. W. Chan, IEEE Trans. Autom. Control 20, 1975). Water that pushes forward
    makes it negative, the target being the torque that is missing, and a controller then takes torque away.
    """
    innovation, torque = np.sqrt(base.weight) * base.innovation, grid.signals.torque
    scale = max(round(grid.signals.scale / grid.cell), 4)
    found = []
    for ahead in sorted({1, max(scale // 8, 2), max(scale // 2, 4)}):
        product, square = 0.0, 0.0
        for begin, end in pairwise(grid.starts):
            if end - begin > ahead + 2:
                change = torque[begin + ahead : end] - torque[begin : end - ahead]
                limit = 3.0 * float(np.median(np.abs(change))) or 4.0 * float(np.std(change))
                change = np.clip(change, -limit, limit)
                product += float(innovation[begin : end - ahead] @ change)
                square += float(change @ change)
        deviation = float(np.sqrt(np.mean(innovation**2)))
        found.append(product / max(deviation * np.sqrt(square), 1e-300))
    return float(max(found, key=abs))
