"""The motion of the last few batches since this start: its share of evidence, motion too fast for the streams, and
whether nothing was learned for want of evidence."""

from __future__ import annotations

from collections import deque

from incsvr.checks.resolution import ResolutionFault, resolution_fault
from incsvr.learning.excitation import Excitation
from incsvr.signals.samples import Samples

RECENT_BATCHES = 5
"""Batches by which is judged whether the vehicle moves enough to be learned, and no quicker than the streams show."""


class RecentBatches:
    """The recent batches of one learner; `add` is called by the thread that learns, all else by any."""

    def __init__(self) -> None:
        self._excitation: deque[Excitation] = deque(maxlen=RECENT_BATCHES)
        self._samples: deque[Samples] = deque(maxlen=RECENT_BATCHES)
        self._trained: deque[bool] = deque(maxlen=RECENT_BATCHES)
        self.unresolved: ResolutionFault | None = None
        """The fault of motion that is too fast for the streams."""
        self.without_evidence_since: float | None = None
        """The first stamp of these batches [s], if hardly any of their motion was evidence and none trained a model."""

    def add(self, excitation: Excitation, batch: Samples, smoothing: float, trained: bool) -> None:
        """A batch was taken, of samples that were smoothed over so long [s]; `trained` if a model was made of it."""
        self._excitation.append(excitation)
        self._samples.append(batch)
        self._trained.append(trained)
        taught_nothing = len(self._trained) == RECENT_BATCHES and not any(self._trained)
        little = Excitation.together(tuple(self._excitation)).little
        self.without_evidence_since = float(self._samples[0].time[0]) if taught_nothing and little else None
        self.unresolved = resolution_fault(Samples.concatenate(tuple(self._samples)), smoothing)

    @property
    def excitation(self) -> Excitation | None:
        """The share of these batches that was evidence about damping; None before the first."""
        parts = tuple(self._excitation)
        return Excitation.together(parts) if parts else None
