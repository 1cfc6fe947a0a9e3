"""What disturbs the motion, and how the likelihood sees it.

The equation of a cell, I Δr/h − τ = −d(r) − …, is disturbed by three things that nobody measures: water that pushes for
some time (an Ornstein–Uhlenbeck moment, seen as its mean over cells), what pushes anew in every cell (white), and the
gyro's white noise, of which Δr holds the difference. Their sum is an ARMA(1, 2) process,

    (1 − φ B) n = σ (1 + c₁ B + c₂ B²) innovation,

so that whitening is one recursive filter. The two c are free: the mean of water over a cell and the drag's answer
within it change them, which sizes of the three would not. The innovation of a cell does not depend on anything before
it, so that regressors that are known at its beginning may follow the rate through a controller: open and closed loop
are alike (L. Ljung, System Identification, 1999, ch. 4 and 13; U. Forssell, L. Ljung, Automatica 35, 1999).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from math import atanh, exp, log, tanh

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

Array = NDArray[np.float64]

MOST = 9.0
"""Of the unbounded numbers: a memory of ten thousand cells, and a reflection of one but for as much."""


@dataclass(frozen=True, slots=True)
class Noise:
    """An ARMA(1, 2), stationary and invertible.

    Attributes:
        pole: φ, of the water over one cell, in (0, 1).
        reflection: k₁, k₂ in (−1, 1): c₂ = k₂ and c₁ = k₁ (1 + k₂) are invertible for every such pair.
    """

    pole: float
    reflection: tuple[float, float]

    @staticmethod
    def start(cell: float, scale: float) -> Noise:
        """Water that lasts for a time scale of the motion, and much of the gyro. Both in s."""
        return Noise(exp(-cell / scale), (-0.8, 0.0))

    def within(self, cell: float, scale: float) -> Noise:
        """The same with water that lasts no longer than the motion's time scale. Both in s."""
        return replace(self, pole=min(self.pole, exp(-cell / scale)))

    @property
    def moving_average(self) -> tuple[float, float]:
        """c₁, c₂."""
        first, second = self.reflection
        return first * (1.0 + second), second

    def whiten(self, values: Array, starts: NDArray[np.intp]) -> Array:
        """(…, n) innovations of `values` (…, n), of every piece from `starts` (pieces + 1,) on by itself."""
        out = np.empty_like(values)
        for begin, end in pairwise(starts):
            piece = values[..., begin:end]
            out[..., begin:end] = lfilter((1.0, -self.pole), (1.0, *self.moving_average), piece, axis=-1)
        return out

    def to_vector(self) -> Array:
        """Three numbers without bounds."""
        return np.array([log(self.pole / (1.0 - self.pole)), *(2.0 * atanh(k) for k in self.reflection)])

    @staticmethod
    def from_vector(vector: Array) -> Noise:
        pole, first, second = np.clip(vector, -MOST, MOST).tolist()
        return Noise(1.0 / (1.0 + exp(-pole)), (tanh(0.5 * first), tanh(0.5 * second)))
