"""How well a model predicts a log: its errors, and what it leaves of each sample."""

from __future__ import annotations

from dataclasses import dataclass

from incsvr.numerics import Array


@dataclass(frozen=True, slots=True)
class Score:
    """Errors of a model on a log, of which it says nothing where the log was learned.

    Attributes:
        mae, rmse: mean absolute and root mean square error of the torque that makes each damping sample [N m].
        free_run_rmse: of a simulation from the first velocity [rad/s]; None where it runs away.
        samples: how many samples the log gave.
    """

    mae: float
    rmse: float
    free_run_rmse: float | None
    samples: int


@dataclass(frozen=True, slots=True, eq=False)
class Residual:
    """The part of each damping sample that a model leaves.

    Attributes:
        time: (n,) stamps [s].
        rate: (n,) velocities [rad/s], [m/s].
        effort: (n,) what the sample shows minus what the model predicts [N m], [N].
    """

    time: Array
    rate: Array
    effort: Array
