"""Blocks of the vehicle's own time, which follows from how fast it moves and how fast it settles."""

from __future__ import annotations

from collections.abc import Sequence

from incsvr.tracing.forward.thresholds import BLOCKS_IN_SCALE, BLOCKS_IN_SETTLING
from incsvr.tracing.run import Run, sample_period
from incsvr.tracing.weak.grid import settling_time, time_scale


def block_length(runs: Sequence[Run], inertia: float) -> float:
    """T_b [s] of blocks in which nothing of the motion is lost and noise is averaged, whole periods of the gyro."""
    period = sample_period(runs, "yaw_rate")
    wanted = min(time_scale(runs) / BLOCKS_IN_SCALE, settling_time(runs, inertia) / BLOCKS_IN_SETTLING)
    return max(round(wanted / period), 1) * period
