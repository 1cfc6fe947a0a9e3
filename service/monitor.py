"""The residual of what is served, as it was before each batch was learned, and whether it is white."""

from __future__ import annotations

import math

import numpy as np

from incsvr.learning.model import Model
from incsvr.learning.whiteness import p_value
from incsvr.samples import Array
from service.config import Config
from service.wire import Batch

INDEPENDENT = 5.0
"""Widths of the smoothing between two samples from which on their noise is nearly white."""
MOST_SAMPLES = 5000
"""Whose residual is looked at."""


class Monitor:
    """Of one learner; from one thread alone."""

    def __init__(self, config: Config) -> None:
        self._period, self._window = config.signals.sample_period, config.tracing.window
        self._every = max(math.ceil(INDEPENDENT * config.signals.smoothing / self._period - 1e-9), 1)
        self._known: Array = np.empty((3, 0))  # time, yaw rate and residual of the recent samples
        self._at_rest = 0.0  # what was served at rest before the newest batch [N m]

    def keep(self, model: Model, batch: Batch) -> None:
        """Keeps what was left of a batch before it was learned: what damping takes over later is no alarm then.

        Args:
            model: what is served after it.
        """
        at_rest = self._at_rest
        self._at_rest = float(model.predict(np.zeros(1)).damping[0]) if model.is_trained else 0.0
        if batch.predicted is None:
            return
        time = np.array(batch.time)
        index = np.rint(time / self._period).astype(np.int64)
        # Damping vanishes at rest; a constant moment that was learned as damping is left in the residual.
        residual = np.array(batch.damping) - np.array(batch.predicted) + at_rest
        new = np.stack([time, np.array(batch.rate), residual])[:, index % self._every == 0]
        if self._known.size and new.size and new[0, 0] <= self._known[0, -1]:
            self.clear()
        known = np.concatenate([self._known, new], axis=1)[:, -MOST_SAMPLES:]
        self._known = known[:, known[0] >= time[-1] - self._window]

    def p_value(self) -> float:
        """Of whiteness of the residual that what was served has left in the recent samples; 1 where there is none."""
        if not self._known.size:
            return 1.0
        time, rate, residual = self._known
        return p_value(time, rate, residual, self._every * self._period)

    def forget(self, until: float) -> None:
        """What has been traced is no alarm again: up to this time [s]."""
        self._known = self._known[:, self._known[0] > until]

    def clear(self) -> None:
        """The samples hold other effects from now on, or another clock."""
        self._known = np.empty((3, 0))
