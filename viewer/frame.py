"""One iteration as the viewer gets it, and the recording's three clocks."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from incsvr.learning.model import Model
from service.wire import IterationReport, ModelSnapshot, Points

APPLICATION = "incsvr"
ITERATION, VEHICLE_TIME, WALL_TIME = "iteration", "vehicle_time", "wall_time"

Floats = NDArray[np.float64]


@dataclass(frozen=True)
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

    @cached_property
    def model(self) -> Model | None:
        """The served model; None before anything was learned."""
        if self.snapshot is None or not self.snapshot.model.is_trained:
            return None
        return self.snapshot.model

    @cached_property
    def curve(self) -> Floats:
        """The learned damping over its trained range, (101, 2) [rad/s, N m]; empty without a model."""
        if self.model is None:
            return np.empty((0, 2))
        low, high = self.model.trained_range or (0.0, 0.0)
        rate = low + (high - low) * np.linspace(0.0, 1.0, 101)
        return np.column_stack((rate, self.model.predict(rate).damping))


def positions(points: Points) -> Floats:
    """(n, 2): yaw rate [rad/s], damping [N m]."""
    return np.array((points.rate, points.damping)).T.reshape(-1, 2)
