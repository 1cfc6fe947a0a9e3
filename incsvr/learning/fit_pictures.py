"""The data that a report of a fit draws."""

from __future__ import annotations

from dataclasses import dataclass

from incsvr.learning.free_run import FreeRun
from incsvr.learning.model import Model
from incsvr.signals.samples import Samples


@dataclass(frozen=True, slots=True)
class FitPictures:
    """A learned curve with what it was learned from and what it is judged by.

    Attributes:
        model: the final one.
        samples: all that the recordings gave.
        free_runs: of the model, each of a stretch without a gap.
        where: the recordings that these are of.
        unseen: whether these were not learned from.
    """

    model: Model
    samples: Samples
    free_runs: list[FreeRun]
    where: str
    unseen: bool
