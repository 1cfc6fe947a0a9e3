"""Errors on data that a model was not fitted to, piece by piece."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from incsvr.tracing.run import Array
from incsvr.tracing.skill import Ahead
from incsvr.tracing.statistics import rms


@dataclass(frozen=True, slots=True)
class Errors:
    """Errors on unseen data, piece by piece.

    Attributes:
        time: stamps of the free run [s].
        measured: yaw rate there [rad/s].
        simulated: free run of the hypothesis [rad/s].
        free_run: simulated − measured.
        slope: of the simulated [rad/s²].
        block_time: stamps of the block residuals [s].
        block_rate: mean yaw rate of each block [rad/s].
        block_error: mean free-run error of each block [rad/s].
        block_slope: mean slope of each block [rad/s²].
        mistimed: of each block, as `Blocks` has it.
        torque: (n_b,) block residuals [N m]; of no piece where only the free runs were asked for.
        ahead: multi-step predictions, for each of `skill.HORIZONS`; likewise.
    """

    time: tuple[Array, ...]
    measured: tuple[Array, ...]
    simulated: tuple[Array, ...]
    free_run: tuple[Array, ...]
    slope: tuple[Array, ...]
    block_time: tuple[Array, ...]
    block_rate: tuple[Array, ...]
    block_error: tuple[Array, ...]
    block_slope: tuple[Array, ...]
    mistimed: tuple[Array, ...]
    torque: tuple[Array, ...]
    ahead: tuple[Ahead, ...] = ()

    def free_run_rmse(self) -> float:
        """[rad/s]."""
        return rms(self.free_run)

    def late(self, most: float = np.inf) -> float:
        """By how much the free run comes late as a whole, in least squares, within ± `most` [s]; negative if early."""
        error, slope = np.concatenate(self.free_run), np.concatenate(self.slope)
        late = -float(error @ slope) / max(float(slope @ slope), 1e-300)
        return min(max(late, -most), most)

    def moved(self, by: float) -> Errors:
        """The errors with the free run moved to an earlier time by so many seconds."""
        error, block_error = (
            tuple(error + by * slope for error, slope in zip(errors, slopes, strict=True))
            for errors, slopes in ((self.free_run, self.slope), (self.block_error, self.block_slope))
        )
        return replace(self, free_run=error, block_error=block_error)
