"""Block equations: the weak (integrated) form of I ṙ + d(r) = τ.

Over a block of length T_b the equation of motion integrates to mean(τ) − I₀ Δr/T_b = mean(d(r)) + Σ mean(losses): no
signal is differentiated, and no filter has to commute with the curved d(r). The method is that of weak-form system
identification (D. A. Messenger, D. M. Bortz, "Weak SINDy", Multiscale Model. Simul. 19, 2021), with constant test
functions.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from incsvr.tracing.run import Array

SUBSTEPS = 8
"""Fine steps in the shortest block."""

FEWEST_BLOCKS = 60
"""Fewest block equations from which anything is concluded."""

SETTLING = 0.02
"""Largest part of a run that is given to the thrusters and the water to forget how they began."""


@dataclass(frozen=True, slots=True)
class Blocks:
    """Which fine samples form which block.

    Attributes:
        first: (n_b,) index of each block's first fine sample.
        size: fine steps in a block.
        period: T_b [s].
        with_history: (m,) the blocks that have three predecessors in the same run (an AR(3) reaches that far).
        previous: (3, m) those predecessors.
        start: (runs + 1,) first block of each run, and the end.
        tiled: of each run the fine samples that its blocks cover, but for the one that ends the last.
        used: (n_b,) whether a block counts in a fit.
        mistimed: (n_b,) what a sample period too early or late makes of the command's jump in it [N m].
    """

    first: NDArray[np.intp]
    size: int
    period: float
    with_history: NDArray[np.intp]
    previous: NDArray[np.intp]
    start: NDArray[np.intp]
    tiled: tuple[slice, ...]
    used: NDArray[np.bool_]
    mistimed: Array

    def __len__(self) -> int:
        return self.first.size

    def only(self, used: NDArray[np.bool_]) -> Blocks:
        """The same blocks where only some count in a fit, (n_b,); the others are held out."""
        keep = used[self.with_history] & used[self.previous].all(axis=0)
        return replace(self, with_history=self.with_history[keep], previous=self.previous[:, keep], used=used)

    @property
    def on_time(self) -> Blocks:
        """The same blocks where the command's jumps are as recorded."""
        return replace(self, mistimed=np.zeros(len(self)))

    def mean(self, values: Array) -> Array:
        """Trapezoid mean over every block; `values` (n,) or (n, k) on the fine grid."""
        if values.ndim == 2:
            columns = np.empty((len(self), values.shape[1]), order="F")
            for k, column in enumerate(values.T):
                columns[:, k] = self.mean(column)
            return columns
        # as rows of a matrix the blocks of a run are one product: a copy for every fine step takes three times that
        weights, half = np.full(self.size, 1.0 / self.size), 0.5 / self.size
        weights[0] = half
        means = [
            values[run].reshape(-1, self.size) @ weights
            + half * values[run.start + self.size : run.stop + 1 : self.size]
            for run in self.tiled
        ]
        return means[0] if len(means) == 1 else np.concatenate(means)

    def slope(self, values: Array) -> Array:
        """(x(end) − x(start)) / T_b of every block."""
        slope: Array = (values[self.first + self.size] - values[self.first]) / self.period
        return slope

    def spread(self, values: Array, length: int) -> Array:
        """(length,) a block value held over its fine samples; what two blocks share holds the mean of theirs, what
        is in no block zero."""
        filled = np.zeros(length)
        for run, part in zip(self.tiled, np.split(values, self.start[1:-1]), strict=True):
            filled[run] = np.repeat(part, self.size)
            filled[run.start + self.size : run.stop : self.size] = 0.5 * (part[1:] + part[:-1])
            if part.size:
                filled[run.stop] = part[-1]
        return filled


def split(start: NDArray[np.intp], size: int, step: float, settling: float = 0.0) -> Blocks:
    """Blocks of `size` fine steps over runs that begin at `start` (with the end as last entry).

    The first `settling` seconds of a run are in no block (at most SETTLING of it: short ones have none to spare): what
    thrust a lag, and what motion of the water a memory, holds at the start was decided before the recording.
    """
    firsts = [
        np.arange(a + min(round(settling / step), int(SETTLING * (b - a))), b - size, size, dtype=np.intp)
        for a, b in pairwise(start)
    ]
    edges = np.concatenate([[0], np.cumsum([f.size for f in firsts])]).astype(np.intp)
    position = np.concatenate([np.arange(f.size) for f in firsts])
    with_history = np.flatnonzero(position >= 3)
    return Blocks(
        np.concatenate(firsts),
        size,
        size * step,
        with_history,
        np.stack([with_history - 1, with_history - 2, with_history - 3]),
        edges,
        tuple(slice(int(f[0]), int(f[-1]) + size) if f.size else slice(0, 0) for f in firsts),
        np.ones(position.size, dtype=bool),
        np.zeros(position.size),
    )


def derivative(values: Array, start: NDArray[np.intp], sigma: float) -> Array:
    """Derivative per sample, run by run, by a Gaussian kernel of fourth order; mirrored through the end points.

    The first derivative less half σ² of the third has no second moment: a plain Gaussian adds σ²/2 of the third
    derivative, which passes for a lag.
    """
    out = np.empty_like(values)
    for a, b in pairwise(start):
        pad = min(int(5 * sigma) + 1, b - a - 1)
        x = values[a:b]
        wide = np.concatenate([2 * x[0] - x[pad:0:-1], x, 2 * x[-1] - x[-2 : -pad - 2 : -1]])
        slope = gaussian_filter1d(wide, sigma, order=1, truncate=5.0)
        third = gaussian_filter1d(wide, sigma, order=3, truncate=5.0)
        out[a:b] = (slope - 0.5 * sigma**2 * third)[pad : pad + b - a]
    return out
