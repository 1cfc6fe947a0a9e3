"""Errors on data that a model was not fitted to, piece by piece, and beside those of trivial models."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from incsvr.numerics import Array, root_mean_square
from incsvr.tracing.statistics import rms
from incsvr.tracing.thresholds import HORIZON_SCALES


@dataclass(frozen=True, slots=True)
class Ahead:
    """Predictions over one horizon, each from a measured yaw rate, (m,) each [rad/s].

    Attributes:
        error: of the model at the end of the horizon.
        change: by how much the yaw rate changed, the error of holding the last one.
        rate: measured at the end, the error of zero.
    """

    error: Array
    change: Array
    rate: Array


@dataclass(frozen=True, slots=True)
class Errors:
    """Errors on unseen data, piece by piece.

    Attributes:
        time: stamps of the free run [s].
        measured: yaw rate there [rad/s].
        simulated: free run [rad/s].
        torque: what the model lacks of the torque, means over blocks [N m].
        ahead: multi-step predictions, for each of HORIZON_SCALES.
    """

    time: tuple[Array, ...]
    measured: tuple[Array, ...]
    simulated: tuple[Array, ...]
    torque: tuple[Array, ...]
    ahead: tuple[Ahead, ...] = ()

    @property
    def free_run(self) -> tuple[Array, ...]:
        """Simulated minus measured [rad/s]."""
        return tuple(simulated - rate for simulated, rate in zip(self.simulated, self.measured, strict=True))

    def to_dict(self) -> dict[str, float]:
        """The contract's errors."""
        flat = np.concatenate(self.torque)
        mae, rmse = float(np.mean(np.abs(flat))), root_mean_square(flat)
        return {"torque_mae": mae, "torque_rmse": rmse, "free_run_rmse": rms(self.free_run)}


def horizons(before: Sequence[Ahead], after: Sequence[Ahead]) -> dict[str, Any]:
    """The contract's `horizons`: root mean square multi-step errors [rad/s], keys in time scales of the motion."""
    return {
        f"{horizon:g}": {
            "before": rms([declared.error]),
            "after": rms([traced.error]),
            "hold": rms([traced.change]),
            "zero": rms([traced.rate]),
        }
        for horizon, declared, traced in zip(HORIZON_SCALES, before, after, strict=True)
        if declared.error.size
    }


def trivial(measured: Sequence[Array]) -> dict[str, Mapping[str, float]]:
    """The contract's `trivial`: free-run errors of a rate of zero, and of the first one held, over each piece."""
    held = [piece - piece[0] for piece in measured if piece.size]
    return {"zero": {"free_run_rmse": rms(measured)}, "hold": {"free_run_rmse": rms(held)}}


def beats_zero(error: Mapping[str, Any]) -> bool:
    """Whether the free run with what was found errs less than saying that the vehicle does not turn."""
    return float(error["after"]["free_run_rmse"]) < float(error["trivial"]["zero"]["free_run_rmse"])
