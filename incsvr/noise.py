"""The noise level of the damping samples, tracked from what the model leaves over."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from incsvr.samples import Array

NORMAL = 1.4826  # standard deviation of a normal distribution over its median absolute deviation


@dataclass(frozen=True, slots=True)
class Noise:
    """σ of a sample about the curve: a running mean of each batch's robust variance, over at most `HORIZON` samples.

    Attributes:
        variance: σ² [N² m²].
        seen: samples that the mean stands for.
    """

    variance: float = 0.0
    seen: float = 0.0

    HORIZON = 500.0

    @property
    def sigma(self) -> float:
        """σ [N m]; NaN before the first batch."""
        return self.variance**0.5 if self.seen else float("nan")

    def after(self, residual: Array) -> Noise:
        """The noise level after a batch with these (n,) residuals [N m], n ≥ 1; outliers do not move it."""
        scale = NORMAL * float(np.median(np.abs(residual)))
        seen = min(self.seen, self.HORIZON - residual.size)
        total = seen + residual.size
        return Noise((self.variance * seen + scale * scale * residual.size) / total, total)
