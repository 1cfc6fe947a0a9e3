"""One iteration as the viewer gets it, and the recording's three clocks."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from incsvr.model import Model
from service.wire import IterationReport, ModelSnapshot, Points

APPLICATION = "incsvr"
ITERATION, VEHICLE_TIME, WALL_TIME = "iteration", "vehicle_time", "wall_time"

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Frame:
    """What one iteration shows.

    Attributes:
        report: the sets and figures of the iteration.
        snapshot: the model served after it; None where the learner no longer has it.
        seen: when it happened by the clock on the wall [s since 1970]; None for what was learned before we came.
    """

    report: IterationReport
    snapshot: ModelSnapshot | None
    seen: float | None

    @property
    def model(self) -> Model | None:
        """The served model; None before anything was learned."""
        if self.snapshot is None or not len(self.snapshot.support):
            return None
        return model_of(self.snapshot)


def model_of(snapshot: ModelSnapshot) -> Model:
    """The model that a snapshot carries."""
    support = snapshot.support
    return Model(
        gamma=snapshot.kernel.gamma,
        C=snapshot.C,
        epsilon=snapshot.epsilon,
        support_rate=np.array(support.rate),
        support_damping=np.array(support.damping),
        weight=np.array(support.weight),
        count=np.ones(len(support)),
        sigma=float("nan") if snapshot.sigma is None else snapshot.sigma,
        certified_error=float("nan") if snapshot.certified_error is None else snapshot.certified_error,
    )


def positions(points: Points) -> Floats:
    """(n, 2): yaw rate [rad/s], damping [N m]."""
    return np.column_stack((np.array(points.rate), np.array(points.damping))).reshape(-1, 2)


def clock_text(seconds: float) -> str:
    """The vehicle's time in words: seconds since its start, or the date where it counts from 1970."""
    if seconds > 1e8:
        return datetime.fromtimestamp(seconds).strftime("%Y-%m-%d %H:%M:%S")
    return f"{seconds:.1f} s"
