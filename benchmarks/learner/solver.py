"""The dual solver alone, beside its peers on the same samples, in one process and in turn.

The sets are like the learner's, offline sets, and sets in six dimensions. scikit-learn's `SVR.fit` solves another
problem, with a bias; Eq. 8's passes and clarabel solve ours.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from time import perf_counter
from typing import Any

import clarabel
import numpy as np
from scipy import sparse
from sklearn.svm import SVR

from benchmarks.learner.sample_sets import yaw_samples
from incsvr.learning import dual
from incsvr.learning.kernel import rbf
from incsvr.numerics import Array

GAMMA, C, EPSILON = 10.0, 1000.0, 0.1  # as the paper found them (Section IV-B)
PASSES_GAP = 1e-2
"""Relative duality gap to which Eq. 8's passes run; it certifies some 80 N m, and takes thousands of passes."""

Set = tuple[Array, Array]


def measure(sets: int = 200, few: int = 5, offline: int = 2000) -> dict[str, Any]:
    """Figures of the solver.

    Args:
        sets: how many sets of 110 samples, one for each seed.
        few: on how many of them clarabel and Eq. 8's passes run: they take up to a second each.
        offline: samples of an offline set.
    """
    online = [yaw_samples(seed) for seed in range(sets)]
    solutions = [dual.solve(x, y, gamma=GAMMA, C=C, epsilon=EPSILON) for x, y in online]
    walked = [_seconds(partial(_passes, samples)) for samples in online[:few]]
    figures = _beside_svr(online)
    return {
        "sets": sets,
        **figures,
        "iterations": {
            "median": float(np.median([solution.iterations for solution in solutions])),
            "most": max(solution.iterations for solution in solutions),
        },
        "certified_error_nm": max(solution.certified_error for solution in solutions),
        "apart_from_clarabel_nm": max(
            float(np.abs(rbf(x, x, GAMMA) @ solution.weight - by_clarabel(x, y, GAMMA, C, EPSILON)).max())
            for (x, y), solution in zip(online[:few], solutions, strict=False)
        ),
        "ratio_to_coordinate_descent": 1e3 * float(np.median(walked)) / figures["solve_ms"]["median"],
        "offline": _beside_svr(
            [yaw_samples(seed, old=offline // 2, new=offline - offline // 2) for seed in range(few)]
        ),
        "six_dimensions": six_dimensions(4 * few),
    }


def six_dimensions(sets: int = 40) -> dict[str, Any]:
    """The same beside `SVR.fit` on sets in six dimensions."""
    return _beside_svr([_in_six_dimensions(seed) for seed in range(sets)])


def by_clarabel(x: Array, y: Array, gamma: float, C: float, epsilon: float) -> Array:
    """f (n,) at the samples by an interior point that shares nothing with ours.

    The primal min ½‖w‖² + C Σ (ξᵢ + ξ'ᵢ) with y − Lw ≤ ε + ξ and Lw − y ≤ ε + ξ', L from the kernel's eigenvectors.
    """
    n = y.size
    values, vectors = np.linalg.eigh(rbf(x, x, gamma))
    L = vectors[:, values > 1e-15] * np.sqrt(values[values > 1e-15])
    rank = L.shape[1]
    one, none, low, aside = sparse.eye(n), sparse.csc_matrix((n, n)), sparse.csc_matrix(L), sparse.csc_matrix((n, rank))
    A = sparse.block_array([[-low, -one, none], [low, none, -one], [aside, -one, none], [aside, none, -one]])
    P = sparse.diags(np.r_[np.ones(rank), np.zeros(2 * n)])
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs, settings.tol_gap_rel, settings.tol_feas = 1e-13, 1e-15, 1e-13
    solver = clarabel.DefaultSolver(
        sparse.csc_matrix(P),
        np.r_[np.zeros(rank), np.full(2 * n, C)],
        sparse.csc_matrix(A),
        np.r_[epsilon - y, epsilon + y, np.zeros(2 * n)],
        [clarabel.NonnegativeConeT(4 * n)],
        settings,
    )
    w: Array = np.array(solver.solve().x[:rank])
    f: Array = L @ w
    return f


def _beside_svr(sets: Sequence[Set]) -> dict[str, Any]:
    """Solving each set and `SVR.fit` on it, in turn."""
    _ours(sets[0])  # warm: the first calls load what they need
    _svr(sets[0])
    times = np.array([(_seconds(partial(_ours, samples)), _seconds(partial(_svr, samples))) for samples in sets])
    ours, theirs = np.median(times, axis=0)
    return {
        "n": sets[0][1].size,
        "solve_ms": {"median": 1e3 * float(ours), "p99": 1e3 * float(np.percentile(times[:, 0], 99))},
        "sklearn_svr_fit_ms": 1e3 * float(theirs),
        "ratio_to_sklearn_svr_fit": float(theirs / ours),
    }


def _seconds(call: Callable[[], object]) -> float:
    began = perf_counter()
    call()
    return perf_counter() - began


def _ours(samples: Set) -> object:
    return dual.solve(*samples, gamma=GAMMA, C=C, epsilon=EPSILON)


def _passes(samples: Set) -> object:
    return dual.coordinate_descent(*samples, gamma=GAMMA, C=C, epsilon=EPSILON, passes=100_000, gap=PASSES_GAP)


def _svr(samples: Set) -> object:
    x, y = samples
    return SVR(gamma=GAMMA, C=C, epsilon=EPSILON).fit(x.reshape(y.size, -1), y)


def _in_six_dimensions(seed: int) -> Set:
    """Where the kernel has full rank: six velocities of half a unit, the first with a quadratic drag."""
    rng = np.random.default_rng(seed)
    x = 0.5 * rng.normal(size=(110, 6))
    return x, 60.0 * x[:, 0] * np.abs(x[:, 0]) + 4.0 * rng.normal(size=110)
