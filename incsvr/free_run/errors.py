"""Free runs of a learned curve held against the runs that were measured."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from incsvr.free_run.integrator import Damping, free_run, tabulated
from incsvr.free_run.motions import Motion
from incsvr.numerics import Array, root_mean_square


@dataclass(frozen=True, slots=True)
class FreeRun:
    """A motion simulated from its first measured yaw rate, beside what was measured.

    Attributes:
        time: (m,) stamps [s].
        measured, simulated: (m,) yaw rates [rad/s]; simulated is NaN from where the model runs away.
    """

    time: Array
    measured: Array
    simulated: Array

    @property
    def error(self) -> Array:
        """(m,) [rad/s]."""
        return self.simulated - self.measured


def free_run_rmse(runs: Sequence[Motion], inertia: float, damping: Callable[[Array], Array]) -> float | None:
    """RMSE of the free runs [rad/s]; None where there is none, or one runs away."""
    return rmse(free_run_errors(runs, inertia, damping))


def free_run_errors(runs: Sequence[Motion], inertia: float, damping: Callable[[Array], Array]) -> list[Array]:
    """(m,) simulated minus measured yaw rate of each motion [rad/s], NaN from where it runs away."""
    fastest = max((float(np.abs(run.yaw_rate).max()) for run in runs), default=0.0)
    table = tabulated(damping, 2.0 * max(fastest, 1e-3))
    return [_error(run, inertia, table) for run in runs]


def rmse(errors: Sequence[Array]) -> float | None:
    """The root mean square of free runs' errors [rad/s]; None where there is none, or one runs away."""
    value = root_mean_square(np.concatenate(errors)) if errors else np.nan
    return value if np.isfinite(value) else None


def _error(run: Motion, inertia: float, damping: Damping) -> Array:
    """The error of the free run with this damping, as `Motion.error`."""

    def simulate(time: Array, torque: Array, first: float) -> Array:
        linear = None if run.linear is None else np.interp(time, run.torque_time, run.linear)
        return free_run(time, torque, first, inertia=inertia, damping=damping, linear=linear)

    return run.error(simulate)
