"""Errors of prediction, how they are whitened, and how they move with a hypothesis: windows and innovations alike.

Windows answer a whole time scale and are taken as they are, with one scale; innovations answer one cell and are
whitened along time, by an ARMA(1, 2): water that lasts, white pushes, and the gyro's noise (L. Ljung, System
Identification, 1999, ch. 4 and 13). Nothing else differs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import atanh, exp, log, tanh

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from incsvr.numerics import Array
from incsvr.tracing.cells import Cells
from incsvr.tracing.dynamics import MAX_RATE_FACTOR, Dynamics, MotionModel, Windows, drag_table
from incsvr.tracing.hypothesis import Hypothesis
from incsvr.tracing.response import Response

MAX_LOGIT = 9.0
"""Largest of the unbounded numbers: a memory of ten thousand cells, and a reflection of one but for as much."""
LOGIT_NUDGE = 1e-3
"""Change of an unbounded number over which a slope is taken."""


@dataclass(frozen=True, slots=True)
class Colour:
    """(1 − φ B) e = σ (1 + c₁ B + c₂ B²) innovation along each piece; no colour without pieces.

    Attributes:
        starts: first window of each piece, and the end; empty where errors are taken as they are.
        pole: φ in (0, 1).
        reflection: k₁, k₂ in (−1, 1): c₂ = k₂, c₁ = k₁ (1 + k₂) are invertible for every such pair.
    """

    starts: tuple[int, ...] = ()
    pole: float = 0.5
    reflection: tuple[float, float] = (0.0, 0.0)

    @property
    def vector(self) -> Array:
        """Three numbers without bounds; none without a colour."""
        if not self.starts:
            return np.empty(0)
        return np.array([log(self.pole / (1.0 - self.pole)), *(2.0 * atanh(k) for k in self.reflection)])

    def moved(self, vector: Array) -> Colour:
        """The colour with other numbers."""
        if not self.starts:
            return self
        pole, first, second = np.clip(vector, -MAX_LOGIT, MAX_LOGIT).tolist()
        return replace(self, pole=1.0 / (1.0 + exp(-pole)), reflection=(tanh(0.5 * first), tanh(0.5 * second)))

    def whiten(self, errors: Array) -> Array:
        """(…, w) innovations of errors (…, w), each piece by itself."""
        if not self.starts:
            return errors
        first, second = self.reflection
        out = np.empty_like(errors)
        for begin, end in pairwise(self.starts):
            piece = errors[..., begin:end]
            out[..., begin:end] = lfilter((1.0, -self.pole), (1.0, first * (1.0 + second), second), piece, axis=-1)
        return out

    def slopes(self, errors: Array) -> list[Array]:
        """(1, length, w) change of the whitened errors with each of the numbers."""
        vector, found = self.vector, list[Array]()
        for k in range(vector.size):
            low, high = vector.copy(), vector.copy()
            low[k], high[k] = low[k] - LOGIT_NUDGE, high[k] + LOGIT_NUDGE
            change = self.moved(high).whiten(errors) - self.moved(low).whiten(errors)
            found.append((change / (2.0 * LOGIT_NUDGE))[None])
        return found


@dataclass(frozen=True, slots=True)
class Problem:
    """Predictions whose errors are made small.

    Attributes:
        cells: the recordings.
        windows: spans that are predicted.
        offset_deviation: of the prior of the streams' offset [s].
        start: the hypothesis of nothing, from which fits begin.
        colour: of the errors, as fits begin.
        ahead: windows of a time scale, where `windows` look one cell ahead: what predicts them worse is no effect.
        share: part of the recordings that is fitted; long ones are thinned.
    """

    cells: Cells
    windows: Windows
    offset_deviation: float
    start: Hypothesis
    colour: Colour
    ahead: Windows | None = None
    share: float = 1.0

    @property
    def of_innovations(self) -> bool:
        """Whether each window's last error alone is looked at, one cell between two commands ahead."""
        return self.ahead is not None

    def looked_at(self, values: Array) -> Array:
        """(…, length, w) of values the rows whose errors count."""
        return values[..., -1:, :] if self.of_innovations else values

    def dynamics(self, hypothesis: Hypothesis) -> Dynamics:
        """The hypothesis over the cells."""
        return Dynamics(self.cells, motion_model(self.cells, hypothesis))

    def errors(self, hypothesis: Hypothesis, windows: Windows | None = None) -> tuple[Array, Response]:
        """(length, w) simulated minus measured rates [rad/s], and how they answer changes; of other windows if
        given."""
        chosen = self.windows if windows is None else windows
        dynamics = self.dynamics(hypothesis)
        course = dynamics.simulate(chosen)
        return course.rate[1:] - self.cells.end[chosen.index], Response(dynamics, chosen, course)


def motion_model(cells: Cells, hypothesis: Hypothesis) -> MotionModel:
    """The hypothesis as a model for a simulation over these cells."""
    limit = MAX_RATE_FACTOR * max(float(np.max(np.abs(cells.signals.rate))), hypothesis.basis.fastest)
    drag = drag_table(lambda rate: hypothesis.damping @ hypothesis.basis.columns(rate), limit)
    return MotionModel(drag, cells.signals.inertia, hypothesis.parts, hypothesis.offset)


def pieces_of(cells: Cells) -> Sequence[slice]:
    """The pieces of the recordings as slices of the cells."""
    return cells.signals.runs()


def blocks_of(cells: Cells, windows: Windows, length: float) -> NDArray[np.intp]:
    """(w,) number of the block of `length` [s] that each window begins in, within its piece."""
    piece = np.searchsorted(cells.start, windows.first, side="right") - 1
    number = np.floor((windows.first - cells.start[piece]) * cells.step / length).astype(np.intp)
    _, block = np.unique(np.stack([piece, number]), axis=1, return_inverse=True)
    return np.asarray(block, dtype=np.intp)
