"""The folds of windows, and the gain of one hypothesis over another in predicting unseen windows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri, stdtr

from incsvr.model_trace.thresholds import FOLD_TURNS, FOLDS, MIN_RUNS
from incsvr.numerics import Array
from incsvr.tracing.errors import Problem
from incsvr.tracing.fit import Fit


def folds_of(problem: Problem) -> NDArray[np.intp]:
    """(w,) the fold of each window: whole recordings where there are enough of them, else parts in turns."""
    run = problem.cells.cell_run[problem.windows.first]
    if np.unique(run).size >= MIN_RUNS:
        return run
    part = max(1, run.size // (FOLD_TURNS * FOLDS))
    return np.asarray((np.arange(run.size) // part) % FOLDS, dtype=np.intp)


@dataclass(frozen=True, slots=True)
class Difference:
    """The gain of one hypothesis over another in predicting unseen windows.

    Attributes:
        total: sum of the differences of log densities.
        error: its standard error, from blocks.
        blocks: how many there are.
        inflation: by how much more the better one's numbers vary than independent windows would have it.
        share: part of the mean squared error that is taken away.
    """

    total: float
    error: float
    blocks: int
    inflation: float
    share: float

    @property
    def evidence(self) -> float:
        """The logarithm of the likelihood ratio, as if windows were independent."""
        return self.total / self.inflation

    @property
    def deviations(self) -> float:
        """The total in standard errors, of a normal law as improbable as Student's of so many blocks."""
        t = self.total / max(self.error, 1e-300)
        if t <= 0.0 or self.blocks < 2:
            return min(t, 0.0)
        return -float(ndtri(max(float(stdtr(self.blocks - 1, -t)), 1e-300)))


def difference(better: Array, worse: Array, blocks: NDArray[np.intp], inflation: float = 1.0) -> Difference:
    """The difference of (w,) log densities of unseen windows; `blocks` (w,) numbers independent stretches."""
    gain = better - worse
    sums, total = np.bincount(blocks, gain), float(gain.sum())
    spread = float(np.std(sums, ddof=1)) if sums.size > 1 else np.inf
    share = 1.0 - float(np.exp(-2.0 * total / gain.size))
    return Difference(total, spread * float(np.sqrt(sums.size)), sums.size, inflation, share)


def inflation(fitted: Fit, blocks: NDArray[np.intp]) -> float:
    """The factor on the free numbers' variance, because windows are not independent: tr(A⁻¹ B)/p, at least 1.

    A is the information, B the covariance of the likelihood's slopes summed over blocks (the composite likelihood's
    correction: C. Varin, N. Reid, D. Firth, Statistica Sinica 21, 2011).
    """
    information, sums = slopes(fitted, blocks)
    known = np.diag(information) > 0.0
    ratio = np.linalg.lstsq(information[np.ix_(known, known)], (sums @ sums.T)[np.ix_(known, known)])[0]
    return max(float(np.trace(ratio)) / max(int(known.sum()), 1), 1.0)


def slopes(fitted: Fit, blocks: NDArray[np.intp]) -> tuple[Array, Array]:
    """(p, p) information, and (p, blocks) slopes of the log likelihood summed over blocks."""
    weighted = fitted.jacobian * fitted.weight
    own = np.einsum("plw,lw->pw", weighted, fitted.errors) / fitted.variance
    information = np.einsum("plw,qlw->pq", weighted, fitted.jacobian) / fitted.variance
    return information, np.stack([np.bincount(blocks, row) for row in own])
