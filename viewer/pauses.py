"""Where a stream paused: there a line ends, so that nothing is drawn where nothing came in."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from viewer.frame import Floats

MIN_PAUSE_S = 1.0
"""A stream paused where it had no message for so long [s], and for MIN_PAUSE_STEPS of its usual steps."""
MIN_PAUSE_STEPS = 3.0
"""A stream paused where it had no message for so many of its usual steps, and for MIN_PAUSE_S."""
USUAL_STEP_COUNT = 50
"""The usual step is the median of so many."""


@dataclass
class Pauses:
    """The clock of one line as it goes on, piece by piece."""

    last: float | None = None
    steps: list[float] = field(default_factory=list)

    def broken(self, time: Floats, value: Floats) -> tuple[Floats, Floats]:
        """The (n,) next points of the line, with a point that is no number at the beginning of each pause [s].

        Whoever draws lines leaves such a point out together with the line to it and from it.
        """
        before = time[:1] if self.last is None else np.array([self.last])
        step = np.diff(time, prepend=before)
        usual = float(np.median(self.steps or step[1:] if step.size > 1 or self.steps else step))
        at = np.flatnonzero(step > max(MIN_PAUSE_S, MIN_PAUSE_STEPS * usual))
        self.last = float(time[-1])
        self.steps = [*self.steps, *step[step > 0.0].tolist()][-USUAL_STEP_COUNT:]
        starts = np.concatenate((before, time))[at] + 1e-3  # just after the last point before it
        return np.insert(time, at, starts), np.insert(value, at, np.nan)
