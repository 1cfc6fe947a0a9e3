"""The data that a plot of a fit draws."""

from __future__ import annotations

from dataclasses import dataclass

from incsvr.learning.model import Model
from incsvr.signals.samples import Samples


@dataclass(frozen=True, slots=True)
class FitPictures:
    """A learned curve with what it was learned from.

    Attributes:
        model: the final one.
        samples: all that the recordings gave.
    """

    model: Model
    samples: Samples
