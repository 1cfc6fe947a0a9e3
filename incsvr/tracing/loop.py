"""Does the torque answer the water, is it a command or a measurement, and do the recordings say anything at all?"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from incsvr.errors import BadInput
from incsvr.tracing.fit import Fit
from incsvr.tracing.grid import Grid
from incsvr.tracing.projection import Projection
from incsvr.tracing.thresholds import ANSWERS, DRIVES, IDLE, IDLE_RATE, LEAST_KNOWN, LEAST_RATE, NOISY, REVERSED

Array = NDArray[np.float64]

PAST, RUNNING, AHEAD = 9, (20.0, 100.0), (1, 3)
"""Cells of the torque's past, and of its running means, from which it is foretold; and by how many cells ahead."""


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
    """The strongest correlation of an innovation with what its own past does not foretell of the torque after it, in
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
        whole = np.concatenate([np.arange(a + PAST, b - ahead) for a, b in pairwise(grid.starts) if b - a > 2 * PAST])
        change = torque[whole + ahead] - torque[whole]
        left, usual = change, 0.0
        for _ in range(3):
            kept = np.abs(left) <= 3.0 * usual if usual > 0.0 else np.ones(change.size, dtype=bool)
            left = change - past[whole] @ np.linalg.lstsq(past[whole][kept], change[kept])[0]
            usual = 1.4826 * float(np.median(np.abs(left))) or float(np.std(left))
        left = np.clip(left, -3.0 * usual, 3.0 * usual)
        deviation = float(np.std(innovation)) * np.sqrt(float(left @ left))
        found.append(float(innovation[whole] @ left) / max(deviation, 1e-300))
    return float(max(found, key=abs))
